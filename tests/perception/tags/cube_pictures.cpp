// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/perception/tags/cube_pictures.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace arpent::tags {
namespace {

using Eigen::Vector3d;

constexpr int kSubPixels = 8;
constexpr int kCells = 10;  // of a tag with its white rim
constexpr double kBlack = 18;
constexpr double kWhite = 205;

/// The tags' cells, row 0 on top.
std::array<cv::Mat1b, 4> make_patterns(const std::vector<double>& ids) {
  std::array<cv::Mat1b, 4> patterns;
  apriltag_family_t* family = tag36h11_create();
  for (std::size_t k = 0; k < 4; ++k) {
    image_u8_t* image = apriltag_to_image(family, static_cast<int>(ids[k]));
    patterns[k] = cv::Mat1b(image->height, image->width, image->buf, static_cast<std::size_t>(image->stride)).clone();
    // The library that frees it is not among the test's: an image is two blocks of calloc.
    std::free(image->buf);
    std::free(image);
  }
  tag36h11_destroy(family);
  return patterns;
}

struct Painter {
  const TagCubeConfig& cube;
  const PictureOptions& options;
  std::array<cv::Mat1b, 4> patterns;
  std::array<double, 4> face_light;

  /// Grey of the cube along a ray in the cube's frame; nullopt if the ray misses it.
  [[nodiscard]] std::optional<double> shade(const Vector3d& origin, const Vector3d& direction) const {
    const double half = 0.5 * cube.edge_m;
    double enter = 0, leave = 1e9;
    int axis = -1;
    for (int k = 0; k < 3; ++k) {
      const double a = (-half - origin[k]) / direction[k];
      const double b = (half - origin[k]) / direction[k];
      if (std::min(a, b) > enter) enter = std::min(a, b), axis = k;
      leave = std::min(leave, std::max(a, b));
    }
    if (axis < 0 || enter >= leave) return std::nullopt;
    const Vector3d p = origin + enter * direction;
    if (axis == 2) return 90.0;  // lid
    const int face = axis + (p[axis] > 0 ? 0 : 2);
    const Vector3d outward = Vector3d::Unit(axis) * (p[axis] > 0 ? 1 : -1);
    const double right = p.dot(Vector3d::UnitZ().cross(outward));
    return face_light[static_cast<std::size_t>(face)] * paint(face, right, p.z());
  }

  [[nodiscard]] double paint(int face, double right_m, double up_m) const {
    const double x = right_m / options.true_tag_m + 0.5;  // 0 to 1 across the black square
    const double y = up_m / options.true_tag_m + 0.5;
    if (x > options.card_left && x < options.card_right && y > options.card_bottom && y < options.card_top)
      return options.card_grey;
    const int column = static_cast<int>(std::floor(x * (kCells - 2))) + 1;
    const int row = kCells - 2 - static_cast<int>(std::floor(y * (kCells - 2)));
    if (column < 0 || column >= kCells || row < 0 || row >= kCells) return kWhite;
    return patterns[static_cast<std::size_t>(face)](row, column) > 127 ? kWhite : kBlack;
  }
};

/// Soft texture with dark and bright rectangles in it.
cv::Mat1f make_clutter(const PinholeCamera& camera, std::uint64_t seed) {
  cv::RNG rng(seed);
  cv::Mat1f coarse(camera.height_px / 8, camera.width_px / 8);
  rng.fill(coarse, cv::RNG::NORMAL, 115, 30);
  cv::Mat1f image;
  cv::resize(coarse, image, {camera.width_px, camera.height_px}, 0, 0, cv::INTER_CUBIC);
  for (int i = 0; i < 25; ++i) {
    const cv::Point corner(rng.uniform(0, camera.width_px), rng.uniform(0, camera.height_px));
    cv::rectangle(image, {corner.x, corner.y, rng.uniform(6, 80), rng.uniform(6, 80)}, rng.uniform(10.0, 220.0),
                  cv::FILLED);
  }
  return image;
}

cv::Mat1f draw(const Painter& painter, const PinholeCamera& camera, const Pose& T_cube_cam, cv::Mat1f image) {
  double low_u = 1e9, high_u = -1e9, low_v = 1e9, high_v = -1e9;
  const double half = 0.5 * painter.cube.edge_m;
  for (int k = 0; k < 8; ++k) {
    const Vector3d corner(k & 1 ? half : -half, k & 2 ? half : -half, k & 4 ? half : -half);
    const Vector3d p = T_cube_cam.inverse() * corner;
    if (p.z() < 0.05) return image;
    const Eigen::Vector2d px = camera.project(p);
    low_u = std::min(low_u, px.x()), high_u = std::max(high_u, px.x());
    low_v = std::min(low_v, px.y()), high_v = std::max(high_v, px.y());
  }
  for (int v = std::max(0, static_cast<int>(low_v) - 1); v <= std::min(image.rows - 1.0, high_v + 1); ++v) {
    for (int u = std::max(0, static_cast<int>(low_u) - 1); u <= std::min(image.cols - 1.0, high_u + 1); ++u) {
      double sum = 0;
      for (int k = 0; k < kSubPixels * kSubPixels; ++k) {
        // Each sample has its own column and its own row: an upright edge is placed to 1/64 px, not to 1/8.
        const double i = k % kSubPixels;
        const double j = std::floor(static_cast<double>(k) / kSubPixels);
        const double du = (i + (j + 0.5) / kSubPixels) / kSubPixels - 0.5;
        const double dv = (j + (i + 0.5) / kSubPixels) / kSubPixels - 0.5;
        const Vector3d direction = T_cube_cam.linear() * camera.unproject(u + du, v + dv, 1.0);
        sum += painter.shade(T_cube_cam.translation(), direction).value_or(image(v, u));
      }
      image(v, u) = static_cast<float>(sum / (kSubPixels * kSubPixels));
    }
  }
  return image;
}

cv::Mat1b develop(cv::Mat1f image, std::uint64_t seed, const PictureOptions& options) {
  if (options.lens_sigma_px > 0) cv::GaussianBlur(image, image, {0, 0}, options.lens_sigma_px);
  if (options.motion_px > 0) {
    // A smear of any length: whole pixels and a share of one at both ends.
    const int reach = static_cast<int>(std::ceil(options.motion_px / 2));
    cv::Mat1f kernel(1, 2 * reach + 1);
    for (int i = -reach; i <= reach; ++i) {
      kernel(i + reach) = static_cast<float>(std::clamp(options.motion_px / 2 - std::abs(i) + 0.5, 0.0, 1.0));
    }
    kernel /= cv::sum(kernel)[0];
    cv::filter2D(image, image, -1, kernel);
  }
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double x = (u - image.cols / 2.0) / image.cols;
      const double y = (v - image.rows / 2.0) / image.cols;
      image(v, u) *= static_cast<float>(options.light * (1 - 0.4 * (x * x + y * y)));
    }
  }
  cv::Mat1f noise(image.size());
  cv::RNG rng(seed * 7919 + 17);
  rng.fill(noise, cv::RNG::NORMAL, 0, options.noise_levels);
  cv::Mat1b developed;
  cv::Mat1f(image + noise).convertTo(developed, CV_8U);
  return developed;
}

}  // namespace

RectifiedStereo make_stereo() {
  return {{640, 512, 377, 377, 319.5, 255.5}, 0.26};
}

Pose make_T_body_cam() {
  Pose T_body_cam(R_body_from_camera_axes());
  T_body_cam.translation() = Vector3d(0.20, 0.13, 0.40);
  return T_body_cam;
}

CubePair render_cube(const TagCubeConfig& cube, const Pose& T_world_body, std::uint64_t seed,
                     const PictureOptions& options) {
  const RectifiedStereo stereo = make_stereo();
  Painter painter{cube, options, make_patterns(options.painted_ids.empty() ? cube.ids : options.painted_ids), {}};
  cv::RNG rng(seed + 1000);
  for (double& light : painter.face_light) light = rng.uniform(0.5, 1.0);
  Pose T_world_cube = Pose::Identity();
  T_world_cube.translation() = Vector3d(cube.x_m, cube.y_m, cube.z_m);
  T_world_cube.linear() = so3_exp({0, 0, cube.yaw_rad});
  CubePair pair{T_world_body, {}, {}};
  for (int k = 0; k < 2; ++k) {
    const Pose T_world_cam = T_world_body * make_T_body_cam() * Eigen::Translation3d(k * stereo.baseline_m, 0, 0);
    cv::Mat1f image = make_clutter(stereo.camera, 2 * seed + static_cast<std::uint64_t>(k));
    if (options.with_cube) image = draw(painter, stereo.camera, T_world_cube.inverse() * T_world_cam, image);
    (k == 0 ? pair.left : pair.right) = develop(image, 2 * seed + static_cast<std::uint64_t>(k), options);
  }
  return pair;
}

Pose pose_facing(const TagCubeConfig& cube, double range_m, double bearing_rad, double offset_rad) {
  const double direction_rad = cube.yaw_rad + bearing_rad;
  const Vector3d rig_m =
      Vector3d(cube.x_m, cube.y_m, 0) + range_m * Vector3d(std::cos(direction_rad), std::sin(direction_rad), 0);
  Pose T_world_body = Pose::Identity();
  T_world_body.linear() = so3_exp({0, 0, direction_rad + M_PI + offset_rad});
  T_world_body.translation() = rig_m - T_world_body.linear() * Vector3d(make_T_body_cam().translation().x(), 0, 0);
  return T_world_body;
}

}  // namespace arpent::tags
