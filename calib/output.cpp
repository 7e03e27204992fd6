// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/output.h"

#include <fmt/format.h>

#include "common/error.h"

namespace arpent::calib {
namespace {

/// Every digit, and never without a point or an exponent.
std::string number(double value) {
  std::string text = fmt::format("{:.17g}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string list(std::initializer_list<double> values) {
  std::string text;
  for (const double v : values) text += (text.empty() ? "[" : ", ") + number(v);
  return text + "]";
}

std::string camera_yaml(const RawCamera& camera, std::size_t index) {
  const PinholeCamera& p = camera.pinhole;
  const auto& k = camera.coefficients;
  std::string yaml = fmt::format("cam{}:\n  camera_model: pinhole\n  intrinsics: {}\n", index,
                                 list({p.fx_px, p.fy_px, p.cx_px, p.cy_px}));
  const bool equidistant = camera.distortion == DistortionModel::kEquidistant;
  yaml += fmt::format("  distortion_model: {}\n  distortion_coeffs: {}\n", equidistant ? "equidistant" : "radtan",
                      list({k[0], k[1], k[2], k[3]}));
  return yaml + fmt::format("  resolution: [{}, {}]\n  rostopic: /cam{}/image_raw\n", p.width_px, p.height_px, index);
}

std::string matrix(const char* name, int rows, int columns, const std::vector<double>& values) {
  std::string data;
  for (const double v : values) data += (data.empty() ? "" : ", ") + number(v);
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n", name, rows, columns,
                     data);
}

std::string opencv_camera(const RawCamera& camera, int n) {
  const PinholeCamera& p = camera.pinhole;
  const auto& k = camera.coefficients;
  return matrix(fmt::format("M{}", n).c_str(), 3, 3, {p.fx_px, 0, p.cx_px, 0, p.fy_px, p.cy_px, 0, 0, 1}) +
         (camera.distortion == DistortionModel::kEquidistant
              ? matrix(fmt::format("D{}", n).c_str(), 1, 4, {k[0], k[1], k[2], k[3]})
              : matrix(fmt::format("D{}", n).c_str(), 1, 5, {k[0], k[1], k[2], k[3], k[4]}));
}

}  // namespace

std::string to_camchain_yaml(const RigEstimate& rig) {
  std::string yaml;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    yaml += camera_yaml(rig.cameras[c], c);
    if (c == 0) continue;
    const Eigen::Matrix4d T = (rig.T_cam_first[c] * rig.T_cam_first[c - 1].inverse()).matrix();
    yaml += "  T_cn_cnm1:\n";
    for (int r = 0; r < 4; ++r) yaml += "  - " + list({T(r, 0), T(r, 1), T(r, 2), T(r, 3)}) + "\n";
  }
  return yaml;
}

std::string to_opencv_yaml(const StereoCalibration& stereo) {
  ARPENT_ASSERT(stereo.left.distortion == stereo.right.distortion);
  const bool equidistant = stereo.left.distortion == DistortionModel::kEquidistant;
  const Eigen::Matrix3d R = stereo.T_right_left.linear();
  const Eigen::Vector3d T = stereo.T_right_left.translation();
  return fmt::format("%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\n", stereo.left.pinhole.width_px,
                     stereo.left.pinhole.height_px) +
         (equidistant ? "distortion_model: equidistant\n" : "") + opencv_camera(stereo.left, 1) +
         opencv_camera(stereo.right, 2) +
         matrix("R", 3, 3, {R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)}) +
         matrix("T", 3, 1, {T.x(), T.y(), T.z()});
}

RigConfig to_rig_config(const StereoCalibration& stereo, const RigConfig& before) {
  const RigConfig cameras = to_rig(stereo, before.name);
  RigConfig rig = before;
  rig.left = cameras.left;
  rig.right = cameras.right;
  rig.T_right_left = cameras.T_right_left;
  return rig;
}

}  // namespace arpent::calib
