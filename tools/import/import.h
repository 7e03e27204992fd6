// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Turns a recorded or rendered stereo sequence into an LCM log that can be replayed with nothing else at hand: CONFIG
// events (the rig; the processes' parameters for this data), then STEREO_IMAGES (zstd inside) and TRUTH_POSE in the
// order of time.
#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <string>

#include "tools/datasets/dataset.h"

namespace arpent::tools {

/// What suits a data set: its own range and voxel.
struct ImportProfile {
  double min_range_m = 0.3;
  double max_range_m = 5.0;
  double voxel_m = 0.1;
  std::string trajectory_frame = "body";
};

struct ImportedPair {
  Time stamp;
  cv::Mat left, right;
};

struct ImportCounts {
  std::int64_t pairs = 0;
  std::int64_t poses = 0;
  std::int64_t unpaired = 0;
};

/// Writes `log` (and `log`.rig.yaml beside it) through a temporary file: it is whole or not there. `load(i)` gives pair
/// i of `count`. Throws InputError.
ImportCounts write_log(const std::filesystem::path& log, const Dataset& dataset, const ImportProfile& profile,
                       std::size_t count, const std::function<ImportedPair(std::size_t)>& load);

/// KITTI: 3 to 25 m, voxels of 0.2 m. EuRoC: 0.4 to 8 m, 0.1 m.
ImportCounts import_kitti(const std::filesystem::path& folder, const std::filesystem::path& log);
ImportCounts import_euroc(const std::filesystem::path& folder, const std::filesystem::path& log);
/// The sequence that the project renders itself: the rig of the robots in the test arena.
ImportCounts import_rendered(double duration_s, const std::filesystem::path& log);

/// The ideal rig of the robots (config/rigs/wifibot_stereo.yaml).
[[nodiscard]] StereoCalibration wifibot_calibration();

}  // namespace arpent::tools
