// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/config/rig.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/error.h"

namespace arpent {
namespace {

constexpr const char* kModelNames[] = {"none", "radial_tangential", "equidistant"};

RawCamera to_camera(const RigCamera& rig, const std::string& name, std::vector<std::string>& faults) {
  RawCamera camera;
  camera.pinhole = {rig.width_px, rig.height_px, rig.fx_px, rig.fy_px, rig.cx_px, rig.cy_px};
  const auto* const model = std::find(std::begin(kModelNames), std::end(kModelNames), rig.distortion);
  camera.distortion = static_cast<DistortionModel>(model - std::begin(kModelNames));
  const std::size_t given = rig.coefficients.size();
  const bool fits = camera.distortion == DistortionModel::kNone               ? given == 0
                    : camera.distortion == DistortionModel::kRadialTangential ? given == 4 || given == 5
                                                                              : given == 4;
  if (!fits) {
    faults.push_back(fmt::format("{}: {} coefficients do not fit the lens model {}", name, given, rig.distortion));
  } else {
    std::copy(rig.coefficients.begin(), rig.coefficients.end(), camera.coefficients.begin());
  }
  return camera;
}

Pose to_pose(const RigTransform& transform, const std::string& name, std::vector<std::string>& faults) {
  const auto& t = transform.translation_m;
  const auto& q = transform.quaternion_wxyz;
  const auto pose = make_pose({t[0], t[1], t[2]}, {q[0], q[1], q[2], q[3]});
  if (!pose) faults.push_back(name + ": quaternion_wxyz must be a unit quaternion");
  return pose.value_or(Pose::Identity());
}

RigCamera to_rig_camera(const RawCamera& camera) {
  RigCamera rig{camera.pinhole.width_px,
                camera.pinhole.height_px,
                camera.pinhole.fx_px,
                camera.pinhole.fy_px,
                camera.pinhole.cx_px,
                camera.pinhole.cy_px,
                "none",
                {}};
  rig.distortion = kModelNames[static_cast<std::size_t>(camera.distortion)];
  const std::size_t count = camera.distortion == DistortionModel::kNone               ? 0
                            : camera.distortion == DistortionModel::kRadialTangential ? 5
                                                                                      : 4;
  rig.coefficients.assign(camera.coefficients.begin(),
                          camera.coefficients.begin() + static_cast<std::ptrdiff_t>(count));
  return rig;
}

RigTransform to_rig_transform(const Pose& pose) {
  const Eigen::Quaterniond q = canonical_quaternion(pose.linear());
  const auto& t = pose.translation();
  return {{t.x(), t.y(), t.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

}  // namespace

StereoCalibration to_calibration(const RigConfig& rig, const std::string& name) {
  std::vector<std::string> faults;
  StereoCalibration calibration;
  calibration.left = to_camera(rig.left, "left camera", faults);
  calibration.right = to_camera(rig.right, "right camera", faults);
  calibration.T_right_left = to_pose(rig.T_right_left, "T_right_left", faults);
  calibration.T_body_left = to_pose(rig.T_body_cam, "T_body_cam", faults);
  for (const std::string& fault : find_faults(calibration)) faults.push_back(fault);
  if (rig.max_range_m <= rig.min_range_m) faults.emplace_back("max_range_m must be > min_range_m");
  for (std::string& fault : faults) fault = name + ": " + fault;
  if (!faults.empty()) throw InputError(fmt::format("{}", fmt::join(faults, "\n")));
  return calibration;
}

RigConfig to_rig(const StereoCalibration& calibration, const std::string& name) {
  RigConfig rig;
  rig.name = name;
  rig.left = to_rig_camera(calibration.left);
  rig.right = to_rig_camera(calibration.right);
  rig.T_right_left = to_rig_transform(calibration.T_right_left);
  rig.T_body_cam = to_rig_transform(calibration.T_body_left);
  return rig;
}

Rig load_rig(const std::filesystem::path& file) {
  Rig rig;
  rig.config = config::load<RigConfig>(file);
  rig.calibration = to_calibration(rig.config, file.string());
  return rig;
}

}  // namespace arpent
