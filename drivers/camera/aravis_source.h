// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// GenICam cameras (USB3 Vision, GigE Vision) through Aravis, the one place that knows it. Images are Mono8, or the top
// bits of a deeper format; automatic exposure and gain of the camera are switched off, because the pair has one
// controller.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/config/fields.h"
#include "drivers/camera/frame_source.h"

namespace arpent::camera {

/// What holds for both cameras of a rig.
struct AravisParams {
  std::string trigger;
  int packet_size_bytes = 0;
  int buffers = 8;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("trigger", self.trigger, "trigger source, e.g. Line0; empty: the cameras run freely at rate_hz");
    visitor.field("packet_size_bytes", self.packet_size_bytes, "of GigE Vision's stream; 0: found out at the start",
                  config::between(0, 65535));
    visitor.field("buffers", self.buffers, "frames that may wait in the driver", config::between(2, 64));
  }
};

/// One camera of them.
struct AravisDevice {
  std::string name;      ///< "Vendor-serial", "Vendor-model-serial", a serial, or an IPv4 address
  std::string features;  ///< GenICam features set at the start, e.g. "LineSelector=Line1 LineMode=Output"
};

struct ImageFormat {
  int width_px = 640;
  int height_px = 512;
  double rate_hz = 5;
};

/// Throws DeviceLost if there is no such camera or it cannot be set up (it may have been replaced by the next attempt).
[[nodiscard]] std::unique_ptr<FrameSource> open_aravis(const AravisDevice& device, const AravisParams& params,
                                                       const ImageFormat& format, const ExposureSetting& exposure,
                                                       const HostTime& host);

struct AravisListing {
  std::string name;
  std::string protocol;  ///< "GigEVision", "USB3Vision" or "Fake"
  std::string address;
};
/// The cameras that answer; takes about a second. `with_fake`: Aravis' built-in camera Fake_1 too.
[[nodiscard]] std::vector<AravisListing> list_aravis(bool with_fake = false);
/// Makes Aravis' built-in camera Fake_1 available.
void enable_fake_camera();

}  // namespace arpent::camera
