// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/depth_sensor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace arpent::sim {
namespace {

/// sigma(4 m) = 0.1 16 / (377 0.26) = 16.3 mm before the filter; the filter keeps sqrt(36) / 16 = 0.375 of it.
TEST(DepthSensor, NoiseHasTheDeviationOfTheFormula) {
  const cv::Mat1f truth(200, 200, 4.0F);
  const NoisyDepth depth = sense_depth(truth, {}, 3);
  double sum = 0, squares = 0;
  for (int v = 1; v < 199; ++v) {
    for (int u = 1; u < 199; ++u) {
      const double error = static_cast<double>(depth.depth_m(v, u)) - 4;
      sum += error;
      squares += error * error;
    }
  }
  const double expected = 0.1 * 16 / (377 * 0.26) * 0.375;
  EXPECT_NEAR(std::sqrt(squares / (198 * 198)) / expected, 1, 0.03);
  EXPECT_NEAR(sum / (198 * 198), 0, 1e-4);
  EXPECT_NEAR(static_cast<double>(depth.sigma_m(100, 100)) / expected, 1, 1e-3);
}

TEST(DepthSensor, NoDepthArisesBetweenTwoSurfaces) {
  cv::Mat1f truth(40, 40, 2.0F);
  truth.colRange(20, 40).setTo(4.0F);
  truth.row(5).setTo(0.0F);
  truth.row(6).setTo(7.0F);
  DepthNoise noise;
  noise.max_range_m = 5;
  const NoisyDepth depth = sense_depth(truth, noise, 3);
  for (int v = 0; v < 40; ++v) {
    for (int u = 0; u < 40; ++u) {
      const float wanted = v == 5 || v == 6 ? 0.0F : truth(v, u);
      EXPECT_NEAR(depth.depth_m(v, u), wanted, 0.08F) << v << " " << u;
      EXPECT_EQ(depth.sigma_m(v, u) > 0, wanted > 0);
    }
  }
}

TEST(DepthSensor, TheSeedDecides) {
  const cv::Mat1f truth(20, 20, 2.0F);
  const auto same = [](const cv::Mat1f& a, const cv::Mat1f& b) { return cv::norm(a, b, cv::NORM_INF) == 0; };
  EXPECT_TRUE(same(sense_depth(truth, {}, 3).depth_m, sense_depth(truth, {}, 3).depth_m));
  EXPECT_FALSE(same(sense_depth(truth, {}, 3).depth_m, sense_depth(truth, {}, 4).depth_m));
}

}  // namespace
}  // namespace arpent::sim
