// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Cameras of the Linux kernel (Video4Linux2: USB video class, MIPI sensors): memory-mapped streaming, stamps of the
// kernel's monotonic clock, so that two devices share one clock. A device that puts both images side by side in one
// frame is split after it (split_halves).
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/camera/frame_source.h"

namespace arpent::camera {

/// The kernel's ioctl, or what a test puts in its place: 0 or more, or -1 with errno.
using Ioctl = std::function<int(int fd, unsigned long request, void* argument)>;

struct V4l2Params {
  std::string device;  ///< e.g. /dev/video0
  int width_px = 640;  ///< of the whole frame: both halves if they are side by side
  int height_px = 512;
  double rate_hz = 5;
  bool control_exposure = true;  ///< false: the device exposes as it likes, and says nothing of it
  ExposureSetting exposure;      ///< gain is not written: V4L2 gains have no unit
  Duration transfer{0};          ///< end of exposure to the stamp, if the device stamps the end of a frame
};

/// Throws DeviceLost if the device is not there or refuses.
[[nodiscard]] std::unique_ptr<FrameSource> open_v4l2(const V4l2Params& params, const HostTime& host,
                                                     const Ioctl& ioctl = {});

/// The left and the right half of a frame that holds both; width must be even.
[[nodiscard]] std::pair<Frame, Frame> split_halves(const Frame& both);

struct V4l2Listing {
  std::string device;
  std::string name;
};
/// The video devices that the kernel knows, from `class_folder`.
[[nodiscard]] std::vector<V4l2Listing> list_v4l2(const std::string& class_folder = "/sys/class/video4linux");

}  // namespace arpent::camera
