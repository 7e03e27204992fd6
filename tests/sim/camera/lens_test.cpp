// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/lens.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

#include "tests/sim/camera/scenes.h"

namespace arpent::sim {
namespace {

RawCamera with_lens(DistortionModel model, const std::array<double, 5>& coefficients) {
  RawCamera camera = half_camera();
  camera.distortion = model;
  camera.coefficients = coefficients;
  return camera;
}

const std::array kLenses{with_lens(DistortionModel::kNone, {}),
                         with_lens(DistortionModel::kRadialTangential, {-0.28, 0.07, 0.0002, -0.0003, 0.01}),
                         with_lens(DistortionModel::kEquidistant, {-0.02, 0.004, -0.003, 0.001, 0})};

TEST(Lens, DistortsAsOpenCvDoes) {
  const cv::Matx33d K(188.5, 0, 159.5, 0, 188.5, 127.5, 0, 0, 1);
  for (double x = -0.8; x <= 0.8; x += 0.4) {
    for (double y = -0.6; y <= 0.6; y += 0.3) {
      const std::vector<cv::Point3d> point{{x, y, 1}};
      std::vector<cv::Point2d> pixel;
      const auto& k = kLenses[1].coefficients;
      cv::projectPoints(point, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), K, std::vector<double>(k.begin(), k.end()),
                        pixel);
      const Eigen::Vector2d ours = 188.5 * distort(kLenses[1], {x, y}) + Eigen::Vector2d(159.5, 127.5);
      EXPECT_NEAR(ours.x(), pixel[0].x, 1e-9);
      EXPECT_NEAR(ours.y(), pixel[0].y, 1e-9);
      const auto& e = kLenses[2].coefficients;
      cv::fisheye::projectPoints(point, pixel, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), K,
                                 cv::Vec4d(e[0], e[1], e[2], e[3]));
      const Eigen::Vector2d fish = 188.5 * distort(kLenses[2], {x, y}) + Eigen::Vector2d(159.5, 127.5);
      EXPECT_NEAR(fish.x(), pixel[0].x, 1e-9);
      EXPECT_NEAR(fish.y(), pixel[0].y, 1e-9);
    }
  }
}

TEST(Lens, UndistortIsTheInverse) {
  for (const RawCamera& camera : kLenses) {
    for (double x = -0.8; x <= 0.8; x += 0.1) {
      const Eigen::Vector2d p(x, 0.7 * x - 0.1);
      EXPECT_LT((undistort(camera, distort(camera, p)) - p).norm(), 1e-9);
    }
  }
}

/// Depth of a slanted plane through a distorted lens: each pixel's ray is the one that OpenCV undistorts it to.
TEST(Lens, PixelsSeeAlongUndistortedRays) {
  const World world = wall_world(3, plain(0.5));
  const Renderer renderer(world);
  const cv::Matx33d K(188.5, 0, 159.5, 0, 188.5, 127.5, 0, 0, 1);
  const double yaw = 0.5;
  Pose T = looking_along_x({0, 0, 0});
  T = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * T;
  const cv::Mat1f depth = renderer.render(CameraModel(kLenses[1]), T, {}).depth_m;
  const auto& k = kLenses[1].coefficients;
  for (int v = 8; v < 256; v += 40) {
    for (int u = 100; u < 320; u += 40) {
      std::vector<cv::Point2d> ideal;
      cv::undistortPoints(std::vector<cv::Point2d>{{double(u), double(v)}}, ideal, K,
                          std::vector<double>(k.begin(), k.end()), cv::noArray(), cv::noArray(),
                          cv::TermCriteria(3, 100, 1e-12));
      // Along x of the world: z cos(yaw) + x sin(yaw) in camera coordinates is 3 m.
      const double z = 3 / (std::cos(yaw) + ideal[0].x * std::sin(yaw));
      if (std::abs(z * ideal[0].y) > 4.9 || z > 8) continue;
      EXPECT_NEAR(static_cast<double>(depth(v, u)), z, 2e-4 * z);
    }
  }
}

}  // namespace
}  // namespace arpent::sim
