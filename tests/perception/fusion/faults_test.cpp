// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The fused pose when one of its inputs is wrong.
#include <gtest/gtest.h>

#include "tests/perception/fusion/drive.h"

namespace arpent::fusion {
namespace {

/// Straight on at 0.5 m/s after 3 s.
Twist2 straight(double t_s) {
  return t_s < 3 ? Twist2{} : Twist2{0.5, 0};
}

/// Odometry that drifts little, so that what a fault adds is seen.
DriveParams quiet() {
  DriveParams p;
  p.odometry_sigma_m = 0.002;
  p.odometry_sigma_rad = 0.0002;
  return p;
}

/// Adds way to what the odometers say: from `from_s` on, `extra_mps` for `for_s`.
std::function<void(double, WheelReading&)> spin(double from_s, double for_s, double extra_mps) {
  return [=](double t_s, WheelReading& r) {
    const double extra_m = extra_mps * std::clamp(t_s - from_s, 0.0, for_s);
    r.left_m += extra_m;
    r.right_m += extra_m;
  };
}

TEST(PoseFusionFaults, SlipIsReportedAndDoesNotMoveThePose) {
  for (const double extra_mps : {0.3, -0.4}) {
    DriveParams p = quiet();
    p.wheel_fault = spin(10, 5, extra_mps);
    const Drive drive = make_drive(p);
    PoseFusion fusion({});
    const auto poses = run(fusion, drive);
    for (const FusedPose& pose : poses) EXPECT_EQ(pose.status, Status::kOk) << pose.reason;
    EXPECT_LT(worst_m(poses, drive), 0.1) << "the slip is 1.5 m or more";
    EXPECT_LT(rms_m(poses, drive), 1.3 * rms_m(odometry_alone(drive), drive));
    EXPECT_GE(fusion.newest_state()->slips, 1);
    EXPECT_FALSE(fusion.newest_state()->slipping) << "it is over";
    EXPECT_EQ(fusion.newest_state()->refused_odometry, 0);
    EXPECT_LT(planar_nees(poses.back(), drive), 16.3) << "chi squared, 3 degrees of freedom, 99.9 %";
  }
}

TEST(PoseFusionFaults, SlipIsFoundWithTheFirstPairsAfterItBegins) {
  DriveParams p = quiet();
  p.duration_s = 12;
  p.wheel_fault = spin(10, 5, 0.3);
  const Drive drive = make_drive(p);
  PoseFusion fusion({});
  for (const Delivery& delivery : deliveries(drive)) {
    ASSERT_EQ(delivery.add(fusion), "");
    const FilterState state = *fusion.newest_state();
    if (state.slips > 0) {
      EXPECT_LT(to_seconds(delivery.at - drive.wheels.front().stamp), 10 + 0.5);
      return;
    }
  }
  FAIL() << "not found";
}

TEST(PoseFusionFaults, EncodersThatStickDoubleOrTurnRoundLeaveOdometryInCharge) {
  const std::function<double(double way_m)> faults[] = {
      [](double) { return 0.0; },
      [](double way_m) { return 2 * way_m; },
      [](double way_m) { return -way_m; },
  };
  for (const auto& fault : faults) {
    // From 10 s on, both sides.
    DriveParams p = quiet();
    p.profile = straight;
    double left_m = 0, right_m = 0;
    bool begun = false;
    p.wheel_fault = [&](double t_s, WheelReading& r) {
      if (t_s < 10) return;
      if (!begun) left_m = r.left_m, right_m = r.right_m;
      begun = true;
      r.left_m = left_m + fault(r.left_m - left_m);
      r.right_m = right_m + fault(r.right_m - right_m);
    };
    const Drive drive = make_drive(p);
    PoseFusion fusion({});
    const auto poses = run(fusion, drive);
    EXPECT_LT(worst_m(poses, drive), 0.1) << "over 15 m";
    EXPECT_TRUE(fusion.newest_state()->slipping);
    EXPECT_EQ(poses.back().status, Status::kOk);
    EXPECT_NEAR(poses.back().twist.speed_mps, 0.5, 0.1) << "as odometry has it";
  }
}

TEST(PoseFusionFaults, AnUnheardBaseLeavesOdometryInCharge) {
  DriveParams p = quiet();
  p.profile = straight;
  p.wheel_fault = [](double t_s, WheelReading& r) { r.usable = t_s < 10; };
  Drive drive = make_drive(p);
  PoseFusion fusion({});
  const auto poses = run(fusion, drive);
  EXPECT_LT(worst_m(poses, drive), 0.1);
  EXPECT_EQ(poses.back().status, Status::kOk);
  // Nor do odometers that are not there at all stop it.
  drive.wheels.resize(500);
  PoseFusion without({});
  EXPECT_LT(worst_m(run(without, drive), drive), 0.1);
}

TEST(PoseFusionFaults, WithoutWheelsAndOdometryItIsLostWithinASecond) {
  DriveParams p = quiet();
  p.duration_s = 12;
  p.profile = straight;
  p.wheel_fault = [](double t_s, WheelReading& r) { r.usable = t_s < 10; };
  p.odometry_fault = [](double t_s, OdometryReading& r) { r.usable = r.anchored = t_s < 10; };
  const Drive drive = make_drive(p);
  PoseFusion fusion({});
  const auto poses = run(fusion, drive);
  EXPECT_EQ(poses[49].status, Status::kOk);    // 9.8 s
  EXPECT_EQ(poses[56].status, Status::kLost);  // 11.2 s
}

TEST(PoseFusionFaults, JumpsOfTheOdometryAreRefused) {
  struct Jump {
    double x_m, y_m, yaw_rad;
  };
  for (const Jump jump : {Jump{0.5, 0, 0}, Jump{-0.5, 0.1, 0}, Jump{0, 0, 0.35}, Jump{0, 0, -0.02}, Jump{1e5, 0, 0}}) {
    DriveParams p = quiet();
    p.profile = straight;
    p.odometry_fault = [jump](double t_s, OdometryReading& r) {
      if (t_s >= 20) r.T_odom_body = Pose2{jump.x_m, jump.y_m, jump.yaw_rad}.to_pose() * r.T_odom_body;
    };
    const Drive drive = make_drive(p);
    PoseFusion fusion({});
    const auto poses = run(fusion, drive);
    EXPECT_LT(worst_m(poses, drive), 0.1) << jump.x_m << ' ' << jump.yaw_rad;
    EXPECT_EQ(fusion.newest_state()->refused_odometry, 1) << jump.x_m << ' ' << jump.yaw_rad;
    EXPECT_EQ(poses[100].status, Status::kDeadReckoning);
    EXPECT_EQ(poses[101].status, Status::kOk) << "the step after the jump is one again";
  }
}

TEST(PoseFusionFaults, OdometryThatSeesSomebodyWalkByDoesNotMoveABaseThatStands) {
  DriveParams p = quiet();
  p.duration_s = 20;
  p.profile = [](double) { return Twist2{}; };
  p.odometry_fault = [](double t_s, OdometryReading& r) {
    r.T_odom_body.translation().y() += 0.05 * std::clamp((t_s - 10) / 0.2, 0.0, 10.0);
  };
  const Drive drive = make_drive(p);
  PoseFusion fusion({});
  const auto poses = run(fusion, drive);
  EXPECT_LT(worst_m(poses, drive), 0.02);
  EXPECT_GE(fusion.newest_state()->refused_odometry, 9);
}

TEST(PoseFusionFaults, ACollisionThatStopsTheBaseWhileItsWheelsTurnIsSeen) {
  DriveParams p = quiet();
  p.duration_s = 16;
  // The base is told to go on; the truth stops.
  p.profile = [](double t_s) { return t_s < 3 || t_s > 10 ? Twist2{} : Twist2{0.5, 0}; };
  p.wheel_fault = [](double t_s, WheelReading& r) {
    if (t_s > 10) r.commanded = {0.5, 0};
    r.left_m += 0.5 * std::max(t_s - 10, 0.0);
    r.right_m += 0.5 * std::max(t_s - 10, 0.0);
  };
  const Drive drive = make_drive(p);
  PoseFusion fusion({});
  const auto poses = run(fusion, drive);
  EXPECT_LT(worst_m(poses, drive), 0.1) << "the wheels go on for 3 m";
  EXPECT_TRUE(fusion.newest_state()->slipping);
}

TEST(PoseFusionFaults, AGyroThatGoesSilentIsReplacedByTheWheels) {
  Drive drive = make_drive(drawn(3));
  drive.gyro.resize(2000);  // 20 s
  PoseFusion fusion({});
  const auto poses = run(fusion, drive);
  EXPECT_LT(rms_m(poses, drive), 1.3 * rms_m(odometry_alone(drive), drive));
}

TEST(PoseFusionFaults, OdometryThatStartsAnewAfterALossMeasuresNoMotion) {
  DriveParams p = quiet();
  p.profile = straight;
  Pose T_restart = Pose::Identity();
  p.odometry_fault = [&](double t_s, OdometryReading& r) {
    if (t_s > 19.9 && t_s < 20.1) T_restart = r.T_odom_body;
    // Lost for three pairs; the fourth repeats the last pose and begins from there.
    if (t_s > 20.1 && t_s < 20.7) r.usable = r.anchored = false, r.T_odom_body = T_restart;
    if (t_s > 20.7 && t_s < 20.9) r.T_odom_body = T_restart, r.step_covariance.setZero();
  };
  const Drive drive = make_drive(p);
  PoseFusion fusion({});
  const auto poses = run(fusion, drive);
  EXPECT_EQ(poses[104].status, Status::kDeadReckoning);
  EXPECT_EQ(poses[104].reason, "visual odometry starts anew");
  EXPECT_LT(error(poses[104], drive).head<2>().norm(), 0.1);
}

}  // namespace
}  // namespace arpent::fusion
