// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// One camera, as its backends give it: single frames with what the device says about them, and one setting of exposure
// and gain. Pairs are made elsewhere (pairer.h); threads and retries too (feed.h).
#pragma once

#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "common/host_time.h"
#include "common/time.h"

namespace arpent::camera {

struct Frame {
  cv::Mat1b image;             ///< raw, 8-bit grey, with its own memory
  std::int64_t frame_id = 0;   ///< the device's counter, as sent
  std::int64_t id_period = 0;  ///< ids run 1 … id_period and begin at 1 again; 0: they never wrap
  std::int64_t session = 0;    ///< counts the openings of the device: counters and clock may start anew with each
  Time device_time;            ///< start of the exposure, by the device's clock
  Time arrival;                ///< when the whole frame was here, by the bus' clock
  int exposure_us = 0;         ///< 0 if unknown
  double gain_db = 0;
};

struct ExposureSetting {
  int exposure_us = 0;
  double gain_db = 0;
  friend bool operator==(const ExposureSetting&, const ExposureSetting&) = default;
};

/// The device does not answer or was taken away: open it again later.
class DeviceLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An open device. Destroying it closes it.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// The next whole frame; waits for it at most about `wait`. Throws DeviceLost.
  [[nodiscard]] virtual std::optional<Frame> next(Duration wait) = 0;
  /// In force from one of the next frames on; each frame says its own. Throws DeviceLost.
  virtual void set_exposure(const ExposureSetting& /*setting*/) {}
  /// Asked when no frame came for long: does the device still answer? Takes at most a fraction of a second.
  [[nodiscard]] virtual bool answers() { return true; }
  /// Frames thrown away so far because parts of them were missing.
  [[nodiscard]] virtual std::int64_t incomplete() const { return 0; }
};

/// Opens a device; may take seconds. Throws DeviceLost if it is not there, InputError if it can never work as
/// configured.
using OpenSource = std::function<std::unique_ptr<FrameSource>()>;

}  // namespace arpent::camera
