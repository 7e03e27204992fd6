// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The rig file (config/rigs): intrinsics of both cameras, their geometry and mounting, and the range in which the rig
// is used.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/camera.h"
#include "common/config/config.h"

namespace arpent {

/// One camera as written in a rig file.
struct RigCamera {
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  std::string distortion = "none";
  std::vector<double> coefficients;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("width_px", self.width_px, "image width", config::between(1, 16384));
    visitor.field("height_px", self.height_px, "image height", config::between(1, 16384));
    visitor.field("fx_px", self.fx_px, "focal length, horizontal", config::greater_than(0.0));
    visitor.field("fy_px", self.fy_px, "focal length, vertical", config::greater_than(0.0));
    visitor.field("cx_px", self.cx_px, "principal point, horizontal; pixel centres are whole numbers");
    visitor.field("cy_px", self.cy_px, "principal point, vertical");
    visitor.field("distortion", self.distortion, "lens model",
                  config::one_of({"none", "radial_tangential", "equidistant"}));
    visitor.field("coefficients", self.coefficients,
                  "radial_tangential: k1, k2, p1, p2[, k3]; equidistant: k1, k2, k3, k4");
  }
};

/// A rigid transform as written in files.
struct RigTransform {
  std::vector<double> translation_m{0, 0, 0};
  std::vector<double> quaternion_wxyz{1, 0, 0, 0};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("translation_m", self.translation_m, "x, y, z", config::finite_numbers(3));
    visitor.field("quaternion_wxyz", self.quaternion_wxyz, "rotation, scalar first", config::finite_numbers(4));
  }
};

struct RigConfig {
  std::string name = "rig";
  RigCamera left;
  RigCamera right;
  RigTransform T_right_left;
  RigTransform T_body_cam;
  double min_range_m = 0.3;
  double max_range_m = 5.0;
  double rate_hz = 5.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("name", self.name, "name of the rig");
    visitor.group("left", self.left, "left camera");
    visitor.group("right", self.right, "right camera");
    visitor.group("T_right_left", self.T_right_left, "maps left-camera coordinates to the right camera's");
    visitor.group("T_body_cam", self.T_body_cam,
                  "maps left-camera coordinates (x right, y down, z forward) to the body");
    visitor.field("min_range_m", self.min_range_m, "nearest depth the rig is used for", config::greater_than(0.0));
    visitor.field("max_range_m", self.max_range_m, "farthest depth the rig is used for", config::between(0.1, 65.0));
    visitor.field("rate_hz", self.rate_hz, "pairs per second", config::between(0.1, 1000.0));
  }
};

/// The calibration that a rig file states. Throws InputError, every fault a line, if it cannot be used.
[[nodiscard]] StereoCalibration to_calibration(const RigConfig& rig, const std::string& name);
[[nodiscard]] RigConfig to_rig(const StereoCalibration& calibration, const std::string& name);

struct Rig {
  RigConfig config;
  StereoCalibration calibration;
};
/// Reads and checks a rig file. Throws InputError.
[[nodiscard]] Rig load_rig(const std::filesystem::path& file);

}  // namespace arpent
