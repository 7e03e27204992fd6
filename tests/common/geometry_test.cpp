// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <unsupported/Eigen/MatrixFunctions>

namespace arpent {
namespace {

Vector6d random_tangent(std::mt19937& generator, double max_angle_rad) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Vector6d delta;
  for (int i = 0; i < 6; ++i) delta[i] = uniform(generator);
  delta.head<3>() *= 5.0;
  delta.tail<3>() *= max_angle_rad / std::sqrt(3.0);
  return delta;
}

TEST(Geometry, RotationExponentialEqualsTheMatrixExponential) {
  std::mt19937 generator(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d w = random_tangent(generator, 3.0).tail<3>();
    Eigen::Matrix3d skew;
    skew << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
    EXPECT_TRUE(so3_exp(w).isApprox(skew.exp(), 1e-12));
  }
}

TEST(Geometry, LogarithmInvertsExponentialAlsoNearZeroAndNearPi) {
  std::mt19937 generator(2);
  for (const double scale : {1e-14, 1e-9, 1e-5, 1.0, 3.0, 3.14159}) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d w = random_tangent(generator, 1.0).tail<3>().normalized() * scale;
      EXPECT_LT((so3_log(so3_exp(w)) - w).norm(), 1e-7 * std::max(1e-3, scale));
    }
  }
}

TEST(Geometry, LocalInvertsRetract) {
  std::mt19937 generator(3);
  for (int i = 0; i < 200; ++i) {
    const Pose T = retract(Pose::Identity(), random_tangent(generator, 3.0));
    const Vector6d delta = random_tangent(generator, 3.0);
    EXPECT_LT((local(T, retract(T, delta)) - delta).norm(), 1e-9);
  }
}

TEST(Geometry, InterpolationMeetsItsEndsAndItsMiddleIsHalfway) {
  std::mt19937 generator(4);
  for (int i = 0; i < 50; ++i) {
    const Pose a = retract(Pose::Identity(), random_tangent(generator, 3.0));
    const Pose b = retract(a, random_tangent(generator, 2.0));
    EXPECT_TRUE(interpolate(a, b, 0.0).isApprox(a, 1e-9));
    EXPECT_TRUE(interpolate(a, b, 1.0).isApprox(b, 1e-9));
    const Pose middle = interpolate(a, b, 0.5);
    EXPECT_NEAR(so3_log(a.linear().transpose() * middle.linear()).norm(),
                so3_log(middle.linear().transpose() * b.linear()).norm(), 1e-9);
  }
}

TEST(Geometry, MakePoseRefusesWhatIsNoRigidMotion) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(make_pose({1, 2, 3}, {1, 0, 0, 0}));
  EXPECT_FALSE(make_pose({nan, 2, 3}, {1, 0, 0, 0}));
  EXPECT_FALSE(make_pose({1, 2, 3}, {nan, 0, 0, 0}));
  EXPECT_FALSE(make_pose({1, 2, 3}, {0, 0, 0, 0}));
  EXPECT_FALSE(make_pose({1, 2, 3}, {2, 0, 0, 0}));
}

TEST(Geometry, CameraAxesInBody) {
  const Eigen::Matrix3d R = R_body_from_camera_axes();
  EXPECT_EQ(R * Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 0, 0)) << "the optical axis looks forward";
  EXPECT_EQ(R * Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, -1, 0)) << "camera right is body right";
  EXPECT_EQ(R * Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, -1)) << "camera down is body down";
}

TEST(Geometry, TheAdjointMovesASmallMotionToTheOtherFrame) {
  const Pose T = Eigen::Translation3d(1, -2, 3) * Eigen::AngleAxisd(0.7, Eigen::Vector3d(2, 1, 2) / 3);
  Vector6d d;
  d << 1e-6, -2e-6, 3e-6, -4e-6, 5e-6, 6e-6;
  const Pose right = retract(T, d);
  const Pose left = retract(Pose::Identity(), adjoint(T) * d) * T;
  EXPECT_LT((right.matrix() - left.matrix()).norm(), 1e-9);
}

}  // namespace
}  // namespace arpent
