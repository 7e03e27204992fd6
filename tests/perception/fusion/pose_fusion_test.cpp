// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/fusion/pose_fusion.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/error.h"
#include "tests/perception/fusion/drive.h"

namespace arpent::fusion {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Estimates at the odometry's times, each made when that odometry has come; as PAIR_POSE is.
std::vector<FusedPose> run(PoseFusion& fusion, const Drive& drive) {
  std::vector<FusedPose> poses;
  std::size_t pair = 0;
  const auto all = deliveries(drive);
  for (const Delivery& delivery : all) {
    EXPECT_EQ(delivery.add(fusion), "");
    if (pair < drive.odometry.size() && delivery.at == drive.odometry[pair].stamp + milliseconds(130)) {
      // The last of this moment: the odometry, which was added after the others.
      const bool last = &delivery == &all.back() || (&delivery + 1)->at > delivery.at;
      if (!last) continue;
      poses.push_back(*fusion.at(drive.odometry[pair].stamp));
      ++pair;
    }
  }
  return poses;
}

Vector6d error(const FusedPose& pose, const Drive& drive) {
  return local(pose.T_frame_body, drive.truth.at(pose.stamp));
}

double rms_m(const std::vector<FusedPose>& poses, const Drive& drive) {
  double squares = 0;
  for (const FusedPose& pose : poses) squares += error(pose, drive).head<2>().squaredNorm();
  return std::sqrt(squares / static_cast<double>(poses.size()));
}

/// Normalised squared error in (x, y, yaw): 3 on average if the covariance is honest.
double planar_nees(const FusedPose& pose, const Drive& drive) {
  const Vector6d e = error(pose, drive);
  const Eigen::Vector3d planar(e(0), e(1), e(5));
  constexpr int kPlanar[] = {0, 1, 5};
  Eigen::Matrix3d P;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) P(r, c) = pose.covariance(kPlanar[r], kPlanar[c]);
  }
  return planar.dot(P.llt().solve(planar));
}

/// A drive whose unknown scale and bias are drawn as the parameters say.
DriveParams drawn(unsigned seed) {
  std::mt19937 random(1000 + seed);
  std::normal_distribution<double> normal;
  DriveParams p;
  p.seed = seed;
  p.distance_scale = 0.02 * normal(random);
  p.gyro_bias_radps = 0.05 * normal(random);
  return p;
}

TEST(PoseFusion, ItsErrorIsAsItsCovarianceSaysAndSmallerThanOdometryAloneOrWheelsAlone) {
  constexpr int kSeeds = 20;
  double nees = 0, fused_m = 0, odometry_m = 0, wheels_m = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const Drive drive = make_drive(drawn(seed));
    PoseFusion fusion({});
    const auto poses = run(fusion, drive);
    ASSERT_EQ(poses.size(), drive.odometry.size());
    nees += planar_nees(poses.back(), drive) / kSeeds;
    fused_m += rms_m(poses, drive) / kSeeds;
    std::vector<FusedPose> alone;
    for (const auto& o : drive.odometry) {
      alone.emplace_back();
      alone.back().stamp = o.stamp;
      alone.back().T_frame_body = o.T_odom_body;
    }
    odometry_m += rms_m(alone, drive) / kSeeds;
    // Wheels and gyro: odometry only at the start.
    Drive blind = drive;
    for (auto& o : blind.odometry) o.usable = o.anchored = o.sequence == 0;
    PoseFusion dead_reckoning({});
    wheels_m += rms_m(run(dead_reckoning, blind), drive) / kSeeds;
  }
  // The mean of 20 chi-squared values with 3 degrees of freedom has deviation sqrt(6/20) = 0.55.
  EXPECT_GT(nees, 3 - 3 * 0.55);
  EXPECT_LT(nees, 3 + 3 * 0.55);
  EXPECT_LT(fused_m, 0.9 * odometry_m);
  EXPECT_LT(fused_m, 0.9 * wheels_m);
  RecordProperty("nees", std::to_string(nees));
  std::printf("NEES %.2f, fused %.4f m, odometry %.4f m, wheels and gyro %.4f m\n", nees, fused_m, odometry_m,
              wheels_m);
}

TEST(PoseFusion, WithoutAGyroWheelsGiveTheTurn) {
  constexpr int kSeeds = 20;
  FusionParams params;
  params.gyro.used = false;
  double nees = 0, fused_m = 0, odometry_m = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    DriveParams p = drawn(seed);
    p.odometry_sigma_rad = 0.003;
    const Drive drive = make_drive(p);
    PoseFusion fusion(params);
    const auto poses = run(fusion, drive);
    nees += planar_nees(poses.back(), drive) / kSeeds;
    fused_m += rms_m(poses, drive) / kSeeds;
    for (const auto& o : drive.odometry)
      odometry_m += (o.T_odom_body.translation() - drive.truth.at(o.stamp).translation()).norm() / kSeeds /
                    static_cast<double>(drive.odometry.size());
  }
  std::printf("NEES %.2f, fused %.4f m, odometry %.4f m\n", nees, fused_m, odometry_m);
  EXPECT_GT(nees, 3 - 3 * 0.55);
  EXPECT_LT(nees, 3 + 3 * 0.55);
  EXPECT_LT(fused_m, odometry_m);
}

}  // namespace
}  // namespace arpent::fusion
