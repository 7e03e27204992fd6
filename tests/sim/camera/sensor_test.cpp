// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/camera/scenes.h"

namespace arpent::sim {
namespace {

/// Radiance that gives `level` at the nominal exposure.
cv::Mat1f flat(double level) {
  return cv::Mat1f(256, 320, static_cast<float>(level / kLevelsPerRadiance));
}
cv::Mat1f depth(double z_m) {
  return cv::Mat1f(256, 320, static_cast<float>(z_m));
}

TEST(Sensor, NoiseIsReadAndShotNoise) {
  SensorParams params;
  params.vignetting = 0;
  const CameraModel camera(half_camera(), params);
  for (const double gain : {1.0, 4.0}) {
    for (const double level : {20.0, 100.0, 180.0}) {
      CameraShot shot;
      shot.gain = gain;
      shot.seed = 3;
      cv::Scalar mean, deviation;
      cv::meanStdDev(camera.expose(flat(level / gain), depth(2), shot), mean, deviation);
      // Read noise 0.8 and shot variance 0.01 per level, both through the gain; rounding adds 1/12.
      const double variance = 0.64 * gain * gain + 0.01 * gain * level + 1.0 / 12;
      EXPECT_NEAR(mean[0], level, 0.1);
      EXPECT_NEAR(deviation[0] * deviation[0] / variance, 1, 0.05) << gain << " " << level;
    }
  }
}

TEST(Sensor, ExposureScalesCornersDarkenAndWhiteSaturates) {
  const CameraModel camera(half_camera());
  CameraShot shot;
  shot.exposure_s = kNominalExposureS / 2;
  const cv::Mat1b half = camera.expose(flat(200), depth(2), shot);
  EXPECT_NEAR(cv::mean(half(cv::Rect(150, 118, 20, 20)))[0], 100, 1);
  EXPECT_NEAR(cv::mean(half(cv::Rect(0, 0, 10, 10)))[0], 76, 2) << "a quarter less in the corner, nearly";
  EXPECT_EQ(camera.expose(flat(2000), depth(2), {})(128, 160), 255);
  EXPECT_LT(camera.expose(flat(0), depth(2), {})(128, 160), 6);
}

/// A bright column on black, the camera turning: it becomes a box whose width is fx w t (1 + x^2), and keeps its light.
TEST(Sensor, MotionBlurIsAsLongAsThePixelMoves) {
  const CameraModel camera(half_camera(), ideal());
  cv::Mat1f line = flat(0);
  line.col(160).setTo(static_cast<float>(200 / kLevelsPerRadiance));
  CameraShot shot;
  shot.exposure_s = kNominalExposureS;
  shot.twist_cam << 0, 0, 0, 0, 8, 0;  // about y down: to the right, the picture moves left
  const cv::Mat1b blurred = camera.expose(line, depth(2), shot);
  const double length = 188.5 * 8 * kNominalExposureS;
  double light = 0, second = 0;
  for (int u = 0; u < 320; ++u) {
    light += blurred(128, u);
    second += blurred(128, u) * std::pow(u - 160.0, 2);
  }
  EXPECT_NEAR(light, 200, 12);
  // A box of width L has variance L^2 / 12; sampling a pixel with linear weights adds 1/6.
  EXPECT_NEAR(std::sqrt(12 * (second / light - 1.0 / 6)), length, 0.15 * length);
}

TEST(Sensor, PixelMotionAgreesWithFiniteDifferences) {
  const PinholeCamera camera = half_camera().pinhole;
  CameraShot shot;
  shot.twist_cam << 0.3, -0.2, 0.5, 0.4, 1.0, -0.6;
  const PixelMotion motion(camera, shot);
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(0.5, -0.3, 2), Eigen::Vector3d(-1, 0.8, 3), Eigen::Vector3d(0, 0, 0.5)}) {
    const double t = 1e-5;
    Vector6d step = t * shot.twist_cam;
    const Pose T_before_after = retract(Pose::Identity(), step);
    const Eigen::Vector2d moved = camera.project(T_before_after.inverse() * p) - camera.project(p);
    const Eigen::Vector2d rate = moved / t * shot.exposure_s;
    const Eigen::Vector2f ours =
        motion.at(static_cast<float>(p.x() / p.z()), static_cast<float>(p.y() / p.z()), static_cast<float>(p.z()));
    EXPECT_LT((ours.cast<double>() - rate).norm(), 1e-3 * std::max(1.0, rate.norm()));
  }
}

TEST(Sensor, WithoutMotionNothingIsBlurred) {
  const CameraModel camera(half_camera(), ideal());
  cv::Mat1f line = flat(10);
  line.col(160).setTo(static_cast<float>(200 / kLevelsPerRadiance));
  const cv::Mat1b still = camera.expose(line, depth(2), {});
  EXPECT_EQ(still(128, 159), 10);
  EXPECT_EQ(still(128, 160), 200);
}

}  // namespace
}  // namespace arpent::sim
