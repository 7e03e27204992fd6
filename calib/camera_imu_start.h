// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Where calib/camera_imu starts from: which samples belong together, the clocks' offset by correlation, the rotation by
// turns alone.
#pragma once

#include <vector>

#include "calib/camera_imu.h"
#include "calib/camera_imu_errors.h"

namespace arpent::calib::camera_imu {

/// Offsets beyond are not looked for.
inline constexpr double kSearchS = 0.5;

/// Two samples of the camera with readings in between.
struct Span {
  std::size_t from, to;
};
[[nodiscard]] std::vector<Span> spans_of(const std::vector<CameraSample>& camera, const Readings& readings,
                                         double offset_s);

/// Rotation vector of the camera from one sample to the next.
[[nodiscard]] Eigen::Vector3d turn_of(const CameraSample& a, const CameraSample& b);

struct Offset {
  double s = 0;
  bool shown = false;  ///< whether other offsets are any worse
};
/// The offset at which the unit turns as fast as the camera does. Throws InputError if there is none.
[[nodiscard]] Offset search_offset(const Readings& readings, const std::vector<CameraSample>& camera);

/// The rotation that takes the unit's turns to the camera's (Wahba's problem); what no turn shows comes from
/// `input.T_cam_imu`.
[[nodiscard]] Eigen::Matrix3d align_turns(const CameraImuInput& input, const Readings& readings,
                                          const std::vector<Span>& spans, double offset_s);

}  // namespace arpent::calib::camera_imu
