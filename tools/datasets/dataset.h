// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A recorded stereo sequence on disk, as the readers of public data sets hand it on: calibration, image files with
// times, true poses if there are any.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/camera.h"
#include "common/time.h"

namespace arpent::tools {

struct DatasetFrame {
  Time stamp;
  std::filesystem::path left;
  std::filesystem::path right;
};

struct TruePose {
  Time stamp;
  Pose T_world_body;
};

struct Dataset {
  std::string name;
  StereoCalibration calibration;  ///< T_body_left included
  std::vector<DatasetFrame> frames;
  std::vector<TruePose> truth;  ///< empty if unknown
  double rate_hz = 10.0;
  int unpaired = 0;              ///< images without a partner, left out
  std::string trajectory_frame;  ///< what the data set's poses are of: "cam0" or "imu"
};

/// Time of the first frame of a data set that counts from zero.
inline constexpr Time kDatasetEpoch = Time(std::chrono::seconds(1'000'000));

/// KITTI odometry: image_0, image_1, calib.txt (with or without `P0:` labels), poses.txt and times.txt if there, 10 Hz
/// otherwise. The images are rectified. Body: the left camera's place with body axes; world: the body at the first
/// pose, T_world_body = T_bc T_cam0(0)_cam0(i) T_bc^-1. Throws InputError.
[[nodiscard]] Dataset read_kitti(const std::filesystem::path& folder);

/// EuRoC (ASL): mav0/cam0, mav0/cam1 (data.csv, sensor.yaml, data/), state_groundtruth_estimate0 if there. Raw images;
/// pairs by equal time stamp; body: the IMU. `folder` is the one that holds mav0, or mav0 itself. Throws InputError.
[[nodiscard]] Dataset read_euroc(const std::filesystem::path& folder);

}  // namespace arpent::tools
