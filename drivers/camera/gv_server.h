// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A GigE Vision camera on this machine: real GVCP and GVSP over the network, images from a callback. It stands in for
// hardware in tests, and lets a simulator's frames reach the camera driver by the road that a camera's take. Frames run
// freely at the rate that the client sets, at multiples of the period of the machine's clock, so that two servers run
// in step; exposure and gain that the client sets reach the callback.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "common/time.h"

namespace arpent::camera {

class GvServer {
 public:
  struct Request {
    Time device_time;  ///< start of the exposure, by the device's clock (this machine's)
    std::int64_t frame_id = 0;
    int exposure_us = 0;
    int gain = 0;  ///< the device's own unit
    cv::Size size_px;
  };
  /// Called in the server's thread. An image of another size is not sent: the frame stays black.
  using Render = std::function<cv::Mat1b(const Request&)>;

  /// Listens on `address`, which must be one of this machine's; each server needs its own. Throws InputError.
  GvServer(const std::string& address, const std::string& serial, Render render);
  /// The camera is gone, as if unplugged: open streams fall silent.
  ~GvServer();
  GvServer(const GvServer&) = delete;
  GvServer& operator=(const GvServer&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent::camera
