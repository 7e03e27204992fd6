// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A folder of image files, played like a camera: for recordings of other makers and for tests. Either two folders
// (left/right, cam0/cam1, cam0/data and cam1/data, image_0/image_1) or one with files left* and right*; images in the
// order of their names. Times come from timestamps.txt (one a line, seconds; lines that begin with # are passed over),
// or from names that are nanoseconds (EuRoC), or from a rate.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "common/config/fields.h"
#include "drivers/camera/frame_source.h"

namespace arpent::camera {

struct FolderParams {
  std::filesystem::path path;
  double rate_hz = 5;
  double speed = 1;
  bool repeat = false;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("path", self.path, "folder with the images of both cameras");
    visitor.field("rate_hz", self.rate_hz, "pairs per second if the folder does not say their times",
                  config::between(0.01, 1000.0));
    visitor.field("speed", self.speed, "how much faster than recorded it plays", config::between(0.01, 100.0));
    visitor.field("repeat", self.repeat, "begin again at the end");
  }
};

struct FolderListing {
  std::vector<std::filesystem::path> left;
  std::vector<std::filesystem::path> right;  ///< as many
  std::vector<Duration> time;                ///< since the first pair, at speed 1
};

/// What is in the folder. Throws InputError: no images, unequal numbers, times that do not rise.
[[nodiscard]] FolderListing list_folder(const FolderParams& params);

/// The left and the right images as two sources that never wait; the first pair is due at once, by the clock `now`. A
/// file that cannot be used is passed over and counted as incomplete.
[[nodiscard]] std::pair<std::unique_ptr<FrameSource>, std::unique_ptr<FrameSource>> open_folder(
    const FolderParams& params, const std::function<Time()>& now);

}  // namespace arpent::camera
