// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A simulated camera: the ray of each pixel through the lens, and the sensor behind it. Light becomes grey levels:
// vignetting, exposure, motion blur, noise, quantization.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "common/camera.h"

namespace arpent::sim {

/// A reflectance of 0.45 in mean light (irradiance 1) gives level 115 at this exposure and gain 1.
inline constexpr double kNominalExposureS = 0.004;
inline constexpr double kLevelsPerRadiance = 115 / 0.45;

struct SensorParams {
  double read_levels = 0.8;   ///< Gaussian noise at gain 1, standard deviation
  double shot_levels = 0.10;  ///< times the square root of the level at gain 1
  double vignetting = 0.25;   ///< darkening in the corners
};

/// What changes from picture to picture. The camera's twist is (linear, angular) velocity in its own axes; it and the
/// exposure make the motion blur. The seed makes the noise: no two pictures should share one.
struct CameraShot {
  Vector6d twist_cam = Vector6d::Zero();
  double exposure_s = kNominalExposureS;
  double gain = 1;
  std::uint64_t seed = 0;
};

class CameraModel {
 public:
  /// Throws InputError if the camera has faults (find_faults of common/camera.h).
  explicit CameraModel(const RawCamera& camera, const SensorParams& sensor = {});

  [[nodiscard]] const RawCamera& camera() const { return camera_; }
  [[nodiscard]] int width_px() const { return camera_.pinhole.width_px; }
  [[nodiscard]] int height_px() const { return camera_.pinhole.height_px; }
  /// Rays (x, y, 1) in camera axes of the pixels' centres, row by row.
  [[nodiscard]] const std::vector<float>& ray_x() const { return ray_x_; }
  [[nodiscard]] const std::vector<float>& ray_y() const { return ray_y_; }

  /// The picture that the sensor makes of `radiance`. `depth_m` (0: far away) tells how pixels move during exposure.
  [[nodiscard]] cv::Mat1b expose(const cv::Mat1f& radiance, const cv::Mat1f& depth_m, const CameraShot& shot) const;

 private:
  RawCamera camera_;
  SensorParams sensor_;
  std::vector<float> ray_x_;
  std::vector<float> ray_y_;
  std::vector<float> vignette_;
};

/// How far pixels move during the exposure [px], from the image motion of a moving pinhole (Longuet-Higgins and Prazdny
/// 1980).
class PixelMotion {
 public:
  PixelMotion(const PinholeCamera& camera, const CameraShot& shot)
      : twist_(shot.twist_cam.cast<float>()),
        scale_u_(static_cast<float>(camera.fx_px * shot.exposure_s)),
        scale_v_(static_cast<float>(camera.fy_px * shot.exposure_s)) {}

  /// (du, dv) of a point seen along (x, y, 1), at `depth_m` (0: far away). It moves against the camera: p' = -v - w x
  /// p.
  [[nodiscard]] Eigen::Vector2f at(float x, float y, float depth_m) const {
    const float near = depth_m > 0 ? 1 / depth_m : 0;
    const auto& t = twist_;
    return {scale_u_ * (near * (x * t[2] - t[0]) + x * y * t[3] - (1 + x * x) * t[4] + y * t[5]),
            scale_v_ * (near * (y * t[2] - t[1]) + (1 + y * y) * t[3] - x * y * t[4] - x * t[5])};
  }

 private:
  Eigen::Matrix<float, 6, 1> twist_;
  float scale_u_;
  float scale_v_;
};

}  // namespace arpent::sim
