// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/fusion/pose_fusion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "common/error.h"
#include "tests/perception/fusion/drive.h"

namespace arpent::fusion {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr int kSeeds = 20;
/// The mean of kSeeds chi-squared values with 3 degrees of freedom has this deviation: sqrt(2 * 3 / kSeeds).
const double kNeesSigma = std::sqrt(6.0 / kSeeds);

/// Odometry of [from_s, to_s) is lost, as a pair that cannot be used is.
Drive blinded(Drive drive, double from_s, double to_s) {
  const Time start = drive.odometry.front().stamp;
  Pose last = Pose::Identity();
  for (OdometryReading& o : drive.odometry) {
    const double t_s = to_seconds(o.stamp - start);
    if (t_s >= from_s && t_s < to_s) {
      o.usable = o.anchored = false;
      o.reason = "black image";
      o.T_odom_body = last;
    }
    last = o.T_odom_body;
  }
  return drive;
}

TEST(PoseFusion, ItsErrorIsAsItsCovarianceSaysAndSmallerThanOdometryAloneOrWheelsAlone) {
  double nees = 0, fused_m = 0, odometry_m = 0, wheels_m = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const Drive drive = make_drive(drawn(seed));
    PoseFusion fusion({}), dead_reckoning({});
    const auto poses = run(fusion, drive);
    ASSERT_EQ(poses.size(), drive.odometry.size());
    for (const FusedPose& pose : poses) EXPECT_EQ(pose.status, Status::kOk) << pose.reason;
    EXPECT_EQ(fusion.newest_state()->slips, 0) << "false alarm";
    EXPECT_EQ(fusion.newest_state()->refused_odometry, 0) << "false alarm";
    nees += planar_nees(poses.back(), drive) / kSeeds;
    fused_m += rms_m(poses, drive) / kSeeds;
    odometry_m += rms_m(odometry_alone(drive), drive) / kSeeds;
    wheels_m += rms_m(run(dead_reckoning, blinded(drive, 0.1, 1e9)), drive) / kSeeds;
  }
  EXPECT_NEAR(nees, 3, 3 * kNeesSigma);
  EXPECT_LT(fused_m, 0.9 * odometry_m);
  EXPECT_LT(fused_m, 0.5 * wheels_m);
}

TEST(PoseFusion, WithoutAGyroWheelsGiveTheTurn) {
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
    odometry_m += rms_m(odometry_alone(drive), drive) / kSeeds;
  }
  EXPECT_NEAR(nees, 3, 3 * kNeesSigma);
  EXPECT_LT(fused_m, odometry_m);
}

TEST(PoseFusion, AnOutageOfFiveSecondsIsBridgedAsWellAsTheCovarianceSays) {
  double nees = 0, error_m = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const Drive drive = blinded(make_drive(drawn(seed)), 30.1, 35.1);
    PoseFusion fusion({});
    const auto poses = run(fusion, drive);
    const FusedPose& before = poses[150];  // 30.0 s
    const FusedPose& end = poses[175];     // 35.0 s, the last lost pair
    EXPECT_EQ(before.status, Status::kOk);
    EXPECT_EQ(end.status, Status::kDeadReckoning);
    EXPECT_EQ(end.reason, "visual odometry: black image");
    EXPECT_GT(end.covariance.trace(), before.covariance.trace());
    EXPECT_EQ(poses[176].status, Status::kOk) << "its motion counts from the last good pair";
    nees += planar_nees(end, drive) / kSeeds;
    // What the outage added.
    const Vector6d added = local(before.T_frame_body.inverse() * end.T_frame_body,
                                 drive.truth.at(before.stamp).inverse() * drive.truth.at(end.stamp));
    error_m += added.head<2>().norm() / kSeeds;
  }
  EXPECT_NEAR(nees, 3, 3 * kNeesSigma);
  EXPECT_LT(error_m, 0.05) << "over about 2 m";
}

TEST(PoseFusion, DeadReckoningIsLostBeyondItsBoundAndComesBack) {
  FusionParams params;
  params.max_dead_reckoning_m = 0.03;
  const Drive drive = blinded(make_drive({.profile =
                                              [](double t_s) {
                                                return t_s < 1 ? Twist2{} : Twist2{0.5, 0};
                                              }}),
                              5.1, 25.1);
  PoseFusion fusion(params);
  const auto poses = run(fusion, drive);
  EXPECT_EQ(poses[30].status, Status::kDeadReckoning);
  // 0.01 * sqrt(9.5 m) = 0.031 m, the scale not counted.
  EXPECT_EQ(poses[124].status, Status::kLost);
  EXPECT_NE(poses[124].reason.find("uncertain"), std::string::npos);
  EXPECT_EQ(poses[130].status, Status::kOk);
}

TEST(PoseFusion, OdometryThatIsSilentIsDeadReckoning) {
  Drive drive = make_drive({.duration_s = 12});
  drive.odometry.resize(30);  // until 5.8 s
  PoseFusion fusion({});
  (void)run(fusion, drive);
  const Time last = drive.odometry.back().stamp;
  EXPECT_EQ(fusion.at(drive.wheels.back().stamp)->status, Status::kDeadReckoning);
  EXPECT_EQ(fusion.at(drive.wheels.back().stamp)->odometry_stamp, last);
  EXPECT_EQ(fusion.at(drive.wheels.back().stamp)->reason, "visual odometry is silent");
}

TEST(PoseFusion, BeforeTheFirstOdometryItIsLost) {
  const Drive drive = make_drive({.duration_s = 2});
  PoseFusion fusion({});
  EXPECT_FALSE(fusion.at(drive.wheels.front().stamp));
  for (const WheelReading& r : drive.wheels) EXPECT_EQ(fusion.add(r), "");
  EXPECT_EQ(fusion.at(drive.wheels.back().stamp)->status, Status::kLost);
  EXPECT_EQ(fusion.at(drive.wheels.back().stamp)->reason, "no visual odometry yet");
}

TEST(PoseFusion, TheGyrosBiasAndTheWheelsScaleAreFound) {
  DriveParams p;
  p.duration_s = 60;
  p.gyro_bias_radps = 0.06;
  p.distance_scale = 0.03;
  PoseFusion fusion({});
  const Drive drive = make_drive(p);
  (void)run(fusion, drive);
  const FilterState state = *fusion.newest_state();
  EXPECT_NEAR(state.gyro_bias_radps, 0.06, 0.001);
  EXPECT_NEAR(state.distance_scale, 0.03, 0.005);
  EXPECT_LT(std::abs(state.gyro_bias_radps - 0.06), 4 * std::sqrt(state.P(kGyroBias, kGyroBias)));
  EXPECT_LT(std::abs(state.distance_scale - 0.03), 4 * std::sqrt(state.P(kDistanceScale, kDistanceScale)));
}

TEST(PoseFusion, StandingStillNeitherMovesThePoseNorGrowsItsCovariance) {
  DriveParams p;
  p.duration_s = 120;
  p.gyro_bias_radps = 0.03;
  p.profile = [](double t_s) { return t_s > 2 && t_s < 6 ? Twist2{0.4, 0.3} : Twist2{}; };
  const Drive drive = make_drive(p);
  PoseFusion fusion({});
  const auto poses = run(fusion, drive);
  const FusedPose& stopped = poses[50];  // 10 s
  for (std::size_t i = 50; i < poses.size(); ++i) {
    // The bias that is learned while it stands says more about the heading that it stopped with.
    ASSERT_LT(local(stopped.T_frame_body, poses[i].T_frame_body).norm(), 4e-3) << i;
    const std::size_t settled = std::min<std::size_t>(i, 100);
    ASSERT_LT(local(poses[settled].T_frame_body, poses[i].T_frame_body).norm(), 1e-3) << i;
    ASSERT_LE(poses[i].covariance.trace(), stopped.covariance.trace() * 1.001);
    ASSERT_EQ(poses[i].twist, Twist2{});
  }
  // Odometry alone has walked away meanwhile.
  EXPECT_GT(local(drive.odometry[50].T_odom_body, drive.odometry.back().T_odom_body).norm(), 0.02);
}

/// All bytes of a pose that are numbers.
void append(std::vector<double>& numbers, const FusedPose& pose) {
  const auto add = [&](const auto& matrix) {
    numbers.insert(numbers.end(), matrix.data(), matrix.data() + matrix.size());
  };
  add(pose.T_frame_body.matrix());
  add(pose.covariance);
  numbers.push_back(pose.twist.speed_mps);
  numbers.push_back(pose.twist.turn_rate_radps);
}

TEST(PoseFusion, TheOrderOfArrivalDoesNotChangeAByte) {
  const Drive drive = make_drive({.duration_s = 12, .gyro_bias_radps = 0.02});
  std::vector<double> reference;
  for (unsigned order = 0; order < 4; ++order) {
    std::mt19937 random(order);
    std::uniform_int_distribution<int> jitter(0, order == 0 ? 0 : 400);
    // Each stream keeps its own order; against each other they come up to 0.4 s early or late.
    std::vector<Delivery> all;
    const auto put = [&](const auto& readings, Duration delay) {
      Time last{};
      for (const auto& r : readings) {
        last = std::max(last, r.stamp + delay + milliseconds(jitter(random)));
        all.push_back({last, [r](PoseFusion& f) { return f.add(r); }});
      }
    };
    put(drive.odometry, milliseconds(order == 0 ? 0 : 600));
    put(drive.gyro, milliseconds(order == 2 ? 300 : 0));
    put(drive.wheels, milliseconds(order == 3 ? 200 : 0));
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
    PoseFusion fusion({});
    std::vector<double> numbers;
    std::size_t asked = 0;
    for (const Delivery& delivery : all) {
      ASSERT_EQ(delivery.add(fusion), "");
      // Asking in between must not matter, and what lies 1.2 s back is settled.
      (void)fusion.at(*fusion.newest());
      while (asked < drive.wheels.size() && drive.wheels[asked].stamp + milliseconds(1200) < delivery.at) {
        append(numbers, *fusion.at(drive.wheels[asked].stamp));
        ++asked;
      }
    }
    ASSERT_GT(asked, 400U);
    numbers.resize(400 * 54);
    if (order == 0) reference = numbers;
    EXPECT_EQ(std::memcmp(numbers.data(), reference.data(), numbers.size() * sizeof(double)), 0) << order;
  }
}

TEST(PoseFusion, WhatIsDroppedIsDroppedByItsTime) {
  PoseFusion fusion({});
  const Time t0 = from_utime(100000000);
  EXPECT_EQ(fusion.add(WheelReading{t0}), "");
  EXPECT_EQ(fusion.add(WheelReading{t0 + milliseconds(20)}), "");
  EXPECT_EQ(fusion.add(WheelReading{t0 + milliseconds(20)}), "its time is not after the last one's");
  EXPECT_EQ(fusion.add(WheelReading{t0 + milliseconds(10)}), "its time is not after the last one's");
  EXPECT_EQ(fusion.add(GyroReading{t0 - milliseconds(1900)}), "") << "another stream may be late";
  EXPECT_EQ(fusion.add(OdometryReading{t0 - milliseconds(2100)}), "older than what is kept");
  EXPECT_EQ(fusion.add(GyroReading{t0 + seconds(3)}), "its time leaps");
  EXPECT_EQ(fusion.newest(), t0 + milliseconds(20));
}

TEST(PoseFusion, ATimeBaseThatLeapsIsFollowedOnceConfirmedAndOneStrayTimeIsNot) {
  for (const Duration leap : {Duration(seconds(3600)), Duration(seconds(-60))}) {
    const Drive drive = make_drive({.duration_s = 10});
    Drive later = make_drive({.duration_s = 10, .profile = [](double) { return Twist2{}; }});
    PoseFusion fusion({});
    (void)run(fusion, drive);
    const Pose before = fusion.at(*fusion.newest())->T_frame_body;
    WheelReading stray = drive.wheels.back();
    stray.stamp += leap;
    EXPECT_EQ(fusion.add(stray), "its time leaps");
    EXPECT_LT(local(before, fusion.at(*fusion.newest())->T_frame_body).norm(), 1e-12);
    const Duration shift = drive.wheels.back().stamp + leap - later.wheels.front().stamp + milliseconds(20);
    for (auto& r : later.wheels) r.stamp += shift;
    for (auto& r : later.odometry) r.stamp += shift;
    EXPECT_EQ(fusion.add(later.wheels[0]), "");
    EXPECT_EQ(fusion.add(later.wheels[1]), "");
    EXPECT_EQ(fusion.at(*fusion.newest())->status, Status::kLost);
    for (std::size_t i = 2; i < 20; ++i) EXPECT_EQ(fusion.add(later.wheels[i]), "");
    EXPECT_EQ(fusion.add(later.odometry[1]), "");
    for (std::size_t i = 20; i < 40; ++i) EXPECT_EQ(fusion.add(later.wheels[i]), "");
    EXPECT_EQ(fusion.add(later.odometry[2]), "");
    const FusedPose pose = *fusion.at(*fusion.newest());
    EXPECT_EQ(pose.status, Status::kOk) << pose.reason;
    EXPECT_GT(pose.covariance(0, 0), 0.2) << "nobody knows what happened meanwhile";
    EXPECT_LT(local(before, pose.T_frame_body).head<3>().norm(), 0.05);
  }
}

TEST(PoseFusion, ImpossibleParametersAreOneClearError) {
  FusionParams params;
  params.wheels.track_m = 0;
  EXPECT_THROW(PoseFusion{params}, InputError);
}

}  // namespace
}  // namespace arpent::fusion
