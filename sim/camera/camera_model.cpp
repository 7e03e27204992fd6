// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/camera_model.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/error.h"
#include "sim/camera/lens.h"
#include "sim/world/noise.h"

namespace arpent::sim {
namespace {

constexpr float kStillPx = 0.1F;  ///< motion below this leaves no trace
constexpr int kMostTaps = 64;

constexpr std::size_t kLanes = 8;
using Lanes = std::array<float, kLanes>;

/// Adds eight samples of the image at (u, v), linear between pixels; beyond the border the border's value.
void add_samples(const cv::Mat1f& image, const Lanes& u, const Lanes& v, Lanes& sums) {
  const auto last_u = static_cast<float>(image.cols - 1), last_v = static_cast<float>(image.rows - 1);
  const auto stride = static_cast<int>(image.step1());
  std::array<int, kLanes> at;
  Lanes a, b;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float x = std::min(std::max(u[i], 0.0F), last_u), y = std::min(std::max(v[i], 0.0F), last_v);
    const float u0 = std::min(std::floor(x), last_u - 1), v0 = std::min(std::floor(y), last_v - 1);
    a[i] = x - u0;
    b[i] = y - v0;
    at[i] = static_cast<int>(v0) * stride + static_cast<int>(u0);
  }
  const float* pixels = image.ptr<float>(0);
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float* top = pixels + at[i];
    const float* bottom = top + stride;
    const float upper = top[0] + a[i] * (top[1] - top[0]), lower = bottom[0] + a[i] * (bottom[1] - bottom[0]);
    sums[i] += upper + b[i] * (lower - upper);
  }
}

/// The longest motion of eight pixels [px].
float longest(const Lanes& du, const Lanes& dv) {
  float most2 = 0;
  for (std::size_t i = 0; i < kLanes; ++i) most2 = std::max(most2, du[i] * du[i] + dv[i] * dv[i]);
  return std::sqrt(most2);
}

/// Eight pixels from (u0, v) on: the mean along the way of each during the exposure, centred on it.
void blur_lanes(const cv::Mat1f& image, int u0, int v, const Lanes& du, const Lanes& dv, float length, Lanes& mean) {
  const int taps = std::min(kMostTaps, 1 + static_cast<int>(std::ceil(length)));
  Lanes u, w;
  mean.fill(0);
  for (int k = 0; k < taps; ++k) {
    const float s = (static_cast<float>(k) + 0.5F) / static_cast<float>(taps) - 0.5F;
    for (std::size_t i = 0; i < kLanes; ++i) {
      u[i] = static_cast<float>(u0 + static_cast<int>(i)) + s * du[i];
      w[i] = static_cast<float>(v) + s * dv[i];
    }
    add_samples(image, u, w, mean);
  }
  for (float& value : mean) value /= static_cast<float>(taps);
}

cv::Mat1f blur(const cv::Mat1f& image, const cv::Mat1f& depth_m, const CameraModel& model, const CameraShot& shot) {
  if (shot.twist_cam.isZero()) return image;
  const PixelMotion motion(model.camera().pinhole, shot);
  const float* ray_x = model.ray_x().data();
  const float* ray_y = model.ray_y().data();
  cv::Mat1f blurred(image.size());
  Lanes du, dv, mean;
  for (int v = 0; v < image.rows; ++v) {
    const float* in = image.ptr<float>(v);
    const float* depth = depth_m.ptr<float>(v);
    float* out = blurred.ptr<float>(v);
    const std::size_t row = static_cast<std::size_t>(v) * static_cast<std::size_t>(image.cols);
    for (int u0 = 0; u0 < image.cols; u0 += static_cast<int>(kLanes)) {
      const std::size_t count = std::min(kLanes, static_cast<std::size_t>(image.cols - u0));
      du.fill(0);
      dv.fill(0);
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t at = row + static_cast<std::size_t>(u0) + i;
        const Eigen::Vector2f d = motion.at(ray_x[at], ray_y[at], depth[static_cast<std::size_t>(u0) + i]);
        du[i] = d.x();
        dv[i] = d.y();
      }
      const float length = longest(du, dv);
      if (length < kStillPx) {
        std::copy_n(in + u0, count, out + u0);
        continue;
      }
      blur_lanes(image, u0, v, du, dv, length, mean);
      std::copy_n(mean.begin(), count, out + u0);
    }
  }
  return blurred;
}

}  // namespace

CameraModel::CameraModel(const RawCamera& camera, const SensorParams& sensor) : camera_(camera), sensor_(sensor) {
  const PinholeCamera& pinhole = camera.pinhole;
  const auto faults = find_faults(RectifiedStereo{pinhole, 1.0});
  if (!faults.empty()) throw InputError(faults.front());
  if (pinhole.width_px < 2 || pinhole.height_px < 2) throw InputError("camera: a picture needs 2 x 2 pixels");
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
