// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/camera.h"

#include <cmath>

namespace arpent {
namespace {

void check_pinhole(const PinholeCamera& camera, const std::string& name, std::vector<std::string>& faults) {
  if (camera.width_px <= 0 || camera.height_px <= 0 || camera.width_px > 16384 || camera.height_px > 16384) {
    faults.push_back(name + ": image size must be between 1 and 16384 px");
    return;
  }
  const std::array<double, 4> values{camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px};
  for (const double value : values) {
    if (!std::isfinite(value)) {
      faults.push_back(name + ": intrinsics must be finite numbers");
      return;
    }
  }
  if (camera.fx_px <= 0 || camera.fy_px <= 0) faults.push_back(name + ": focal length must be > 0 [px]");
  if (camera.cx_px < 0 || camera.cx_px > camera.width_px || camera.cy_px < 0 || camera.cy_px > camera.height_px) {
    faults.push_back(name + ": principal point must lie inside the image");
  }
}

void check_baseline(double baseline_m, std::vector<std::string>& faults) {
  if (!std::isfinite(baseline_m)) {
    faults.emplace_back("baseline must be a finite number");
  } else if (baseline_m <= 0) {
    faults.emplace_back("baseline must be > 0 [m]: are left and right swapped?");
  }
}

bool is_rigid(const Pose& T) {
  return T.matrix().allFinite() && (T.linear() * T.linear().transpose()).isIdentity(1e-3) &&
         T.linear().determinant() > 0;
}

}  // namespace

std::vector<std::string> find_faults(const StereoCalibration& calibration) {
  std::vector<std::string> faults;
  check_pinhole(calibration.left.pinhole, "left camera", faults);
  check_pinhole(calibration.right.pinhole, "right camera", faults);
  for (const RawCamera* camera : {&calibration.left, &calibration.right}) {
    for (const double k : camera->coefficients) {
      if (!std::isfinite(k)) faults.emplace_back("distortion coefficients must be finite numbers");
    }
  }
  if (calibration.left.pinhole.width_px != calibration.right.pinhole.width_px ||
      calibration.left.pinhole.height_px != calibration.right.pinhole.height_px) {
    faults.emplace_back("left and right images must have the same size");
  }
  if (!is_rigid(calibration.T_right_left)) faults.emplace_back("T_right_left must be a rigid transform");
  if (!is_rigid(calibration.T_body_left)) faults.emplace_back("T_body_cam must be a rigid transform");
  // The right camera's centre in the left frame has a positive x.
  if (faults.empty()) check_baseline(calibration.T_right_left.inverse().translation().x(), faults);
  return faults;
}

std::vector<std::string> find_faults(const RectifiedStereo& stereo) {
  std::vector<std::string> faults;
  check_pinhole(stereo.camera, "camera", faults);
  check_baseline(stereo.baseline_m, faults);
  return faults;
}

}  // namespace arpent
