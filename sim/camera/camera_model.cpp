// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/camera_model.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "sim/camera/lens.h"
#include "sim/world/noise.h"

namespace arpent::sim {
namespace {

constexpr float kStillPx = 0.1F;  ///< motion below this leaves no trace
constexpr int kMostTaps = 64;

/// Linear between pixels; beyond the border the border's value.
float sample(const cv::Mat1f& image, float u, float v) {
  const float x = std::clamp(u, 0.0F, static_cast<float>(image.cols - 1));
  const float y = std::clamp(v, 0.0F, static_cast<float>(image.rows - 1));
  const int u0 = std::min(static_cast<int>(x), image.cols - 2), v0 = std::min(static_cast<int>(y), image.rows - 2);
  const float a = x - static_cast<float>(u0), b = y - static_cast<float>(v0);
  const float* top = image.ptr<float>(v0) + u0;
  const float* bottom = image.ptr<float>(v0 + 1) + u0;
  const float upper = top[0] + a * (top[1] - top[0]), lower = bottom[0] + a * (bottom[1] - bottom[0]);
  return upper + b * (lower - upper);
}

/// Mean along the way of each pixel during the exposure, centred on it.
cv::Mat1f blur(const cv::Mat1f& image, const cv::Mat1f& depth_m, const CameraModel& model, const CameraShot& shot) {
  if (shot.twist_cam.isZero() || image.cols < 2 || image.rows < 2) return image;
  cv::Mat1f blurred(image.size());
  const PinholeCamera& camera = model.camera().pinhole;
  for (int v = 0; v < image.rows; ++v) {
    const float* in = image.ptr<float>(v);
    const float* depth = depth_m.ptr<float>(v);
    float* out = blurred.ptr<float>(v);
    const std::size_t row = static_cast<std::size_t>(v) * static_cast<std::size_t>(image.cols);
    for (int u = 0; u < image.cols; ++u) {
      const std::size_t i = row + static_cast<std::size_t>(u);
      const Eigen::Vector2f motion = pixel_motion_px(camera, model.ray_x()[i], model.ray_y()[i], depth[u], shot);
      const float length = motion.norm();
      if (length < kStillPx) {
        out[u] = in[u];
        continue;
      }
      const int taps = std::min(kMostTaps, 1 + static_cast<int>(std::ceil(length)));
      float sum = 0;
      for (int k = 0; k < taps; ++k) {
        const float s = (static_cast<float>(k) + 0.5F) / static_cast<float>(taps) - 0.5F;
        sum += sample(image, static_cast<float>(u) + s * motion.x(), static_cast<float>(v) + s * motion.y());
      }
      out[u] = sum / static_cast<float>(taps);
    }
  }
  return blurred;
}

}  // namespace

CameraModel::CameraModel(const RawCamera& camera, const SensorParams& sensor) : camera_(camera), sensor_(sensor) {
  const PinholeCamera& pinhole = camera.pinhole;
  const auto faults = find_faults(RectifiedStereo{pinhole, 1.0});
  if (!faults.empty()) throw InputError(faults.front());
  const double corner2 = 0.25 * (pinhole.width_px * pinhole.width_px + pinhole.height_px * pinhole.height_px);
  for (int v = 0; v < pinhole.height_px; ++v) {
    for (int u = 0; u < pinhole.width_px; ++u) {
      const Eigen::Vector3d plane = pinhole.unproject(u, v, 1.0);
      const Eigen::Vector2d ideal = undistort(camera, plane.head<2>());
      ray_x_.push_back(static_cast<float>(ideal.x()));
      ray_y_.push_back(static_cast<float>(ideal.y()));
      const double du = u - pinhole.cx_px, dv = v - pinhole.cy_px;
      vignette_.push_back(static_cast<float>(std::max(0.05, 1 - sensor.vignetting * (du * du + dv * dv) / corner2)));
    }
  }
}

Eigen::Vector2f pixel_motion_px(const PinholeCamera& camera, float x, float y, float depth_m, const CameraShot& shot) {
  const Eigen::Matrix<float, 6, 1> t = shot.twist_cam.cast<float>();
  const float near = depth_m > 0 ? 1 / depth_m : 0;
  // The scene moves against the camera: p' = -v - w x p.
  const float dx = near * (x * t[2] - t[0]) + x * y * t[3] - (1 + x * x) * t[4] + y * t[5];
  const float dy = near * (y * t[2] - t[1]) + (1 + y * y) * t[3] - x * y * t[4] - x * t[5];
  const auto exposure = static_cast<float>(shot.exposure_s);
  return {static_cast<float>(camera.fx_px) * exposure * dx, static_cast<float>(camera.fy_px) * exposure * dy};
}

cv::Mat1b CameraModel::expose(const cv::Mat1f& radiance, const cv::Mat1f& depth_m, const CameraShot& shot) const {
  const cv::Mat1f light = blur(radiance, depth_m, *this, shot);
  cv::Mat1b picture(light.size());
  const auto gain = static_cast<float>(kLevelsPerRadiance * shot.exposure_s / kNominalExposureS * shot.gain);
  const auto read = static_cast<float>(sensor_.read_levels * shot.gain);
  const auto shot_noise = static_cast<float>(sensor_.shot_levels * sensor_.shot_levels * shot.gain);
  const std::uint32_t seed =
      hash_bits(static_cast<std::uint32_t>(shot.seed), static_cast<std::uint32_t>(shot.seed >> 32));
  for (int v = 0; v < light.rows; ++v) {
    const float* in = light.ptr<float>(v);
    const auto first = static_cast<std::uint32_t>(v * light.cols);
    const float* vignette = vignette_.data() + first;
    std::uint8_t* out = picture.ptr<std::uint8_t>(v);
    for (int u = 0; u < light.cols; ++u) {
      // No more light than fills a pixel a hundred times over: beyond, its noise means nothing.
      const float level = std::min(25500.0F, in[u] * vignette[u] * gain);
      const float sigma = std::sqrt(read * read + shot_noise * level);
      const float noisy = level + sigma * gaussian_of(seed, first + static_cast<std::uint32_t>(u));
      out[u] = static_cast<std::uint8_t>(static_cast<int>(std::clamp(noisy + 0.5F, 0.0F, 255.0F)));
    }
  }
  return picture;
}

}  // namespace arpent::sim
