// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "control/path_tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "common/error.h"
#include "tests/control/plant.h"

namespace arpent::control {
namespace {

constexpr double kPeriodS = 0.05;

/// A straight of 2 m and a quarter turn of 0.6 m radius to the left.
std::vector<Eigen::Vector2d> bend() {
  std::vector<Eigen::Vector2d> points = {{0, 0}};
  for (double a = 0; a <= std::numbers::pi / 2; a += 0.01) {
    points.emplace_back(2 + 0.6 * std::sin(a), 0.6 - 0.6 * std::cos(a));
  }
  points.emplace_back(2.6, 1.6);
  return points;
}

/// Runs until the tracker arrives (or too long); checks every command against the limits.
TrackerOutput drive(PathTracker& tracker, Plant& plant, const Limits& limits, int cycles = 1000) {
  TrackerOutput output;
  std::optional<Twist2> before;
  for (int i = 0; i < cycles; ++i) {
    output = tracker.step(plant.state().stamp, plant.state());
    const Twist2 last = before.value_or(output.command);
    const auto within = [](double now, double then, double most, double rate) {
      EXPECT_LE(std::abs(now), most + 1e-12);
      EXPECT_LE(std::abs(now - then), rate * kPeriodS + 1e-9);
    };
    within(output.command.speed_mps, last.speed_mps, limits.max_speed_mps, limits.max_acceleration_mps2);
    within(output.command.turn_rate_radps, last.turn_rate_radps, limits.max_turn_rate_radps,
           limits.max_turn_acceleration_radps2);
    before = output.command;
    const bool still = output.command.speed_mps == 0 && output.command.turn_rate_radps == 0;
    if (output.mode == TrackerMode::kArrived && still) break;
    plant.move(output.command, kPeriodS);
  }
  plant.move({}, 1.0);
  return output;
}

TEST(PathTracker, ArrivesAtTheGoalWithItsHeading) {
  const TrackerParams params;
  for (const double heading : {1.2, -2.0, 3.0}) {
    PathTracker tracker(params);
    tracker.follow(Path(bend(), params.limits), heading);
    Plant plant({}, {});
    EXPECT_EQ(drive(tracker, plant, params.limits).mode, TrackerMode::kArrived);
    EXPECT_LT((plant.state().p_map_m - Eigen::Vector2d(2.6, 1.6)).norm(), 0.03);
    EXPECT_LT(std::abs(std::remainder(plant.state().yaw_rad - heading, 2 * std::numbers::pi)), 0.04);
    EXPECT_LT(std::abs(plant.state().twist.speed_mps), 1e-3);
  }
}

TEST(PathTracker, APathToTheBackIsTurnedToFirst) {
  const TrackerParams params;
  PathTracker tracker(params);
  tracker.follow(Path(bend(), params.limits), std::nullopt);
  BaseState start;
  start.yaw_rad = 2.8;
  Plant plant({}, start);
  for (int i = 0; i < 10; ++i) {
    const TrackerOutput output = tracker.step(plant.state().stamp, plant.state());
    EXPECT_EQ(output.mode, TrackerMode::kTurnToPath);
    EXPECT_EQ(output.command.speed_mps, 0);
    EXPECT_LE(output.command.turn_rate_radps, 0) << "the short way round";
    plant.move(output.command, kPeriodS);
  }
  EXPECT_EQ(drive(tracker, plant, params.limits).mode, TrackerMode::kArrived);
}

TEST(PathTracker, AnOffsetIsSteeredOutWithoutOvershooting) {
  const TrackerParams params;
  PathTracker tracker(params);
  tracker.follow(Path({{0, 0}, {6, 0}}, params.limits), std::nullopt);
  BaseState start;
  start.p_map_m = {0.5, 0.2};
  Plant plant({.yaw_gain = 1.0}, start);
  double lowest = 0;
  for (int i = 0; i < 150; ++i) {
    plant.move(tracker.step(plant.state().stamp, plant.state()).command, kPeriodS);
    lowest = std::min(lowest, plant.state().p_map_m.y());
  }
  EXPECT_LT(std::abs(plant.state().p_map_m.y()), 0.01);
  EXPECT_GT(lowest, -0.02);
}

/// Bends of up to 1.5 / m to either side, from a base that stands up to 0.4 m beside the begin and looks up to 20
/// degrees aside.
TEST(PathTracker, ABaseThatStandsBesideAnyBendDrivesOnAndNeverBackwards) {
  const TrackerParams params;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int trial = 0; trial < 200; ++trial) {
    const double bends_1pm[] = {1.5 * unit(random), 1.5 * unit(random), 0};
    std::vector<Eigen::Vector2d> points;
    Eigen::Vector2d at(0, 0);
    double heading = 0;
    for (int i = 0; i < 70; ++i) {
      points.push_back(at);
      heading += 0.05 * bends_1pm[std::min(i / 25, 2)];
      at += 0.05 * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    }
    PathTracker tracker(params);
    tracker.follow(Path(points, params.limits), std::nullopt);
    BaseState start;
    start.p_map_m = {0.15 * unit(random), 0.4 * unit(random)};
    start.yaw_rad = 0.34 * unit(random);
    Plant plant({}, start);
    TrackerOutput output;
    while (output.mode != TrackerMode::kArrived && plant.state().stamp < start.stamp + std::chrono::seconds(20)) {
      output = tracker.step(plant.state().stamp, plant.state());
      ASSERT_NE(output.mode, TrackerMode::kBrake) << trial << ": " << output.reason;
      ASSERT_GE(output.command.speed_mps, 0) << trial;
      plant.move(output.command, kPeriodS);
    }
    ASSERT_EQ(output.mode, TrackerMode::kArrived) << trial;
    ASSERT_LT((plant.state().p_map_m - points.back()).norm(), 0.05) << trial;
  }
}

TEST(PathTracker, AStaleOrImpossiblePoseBrakesInTheSameCycleAtTheLimit) {
  const TrackerParams params;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int fault = 0; fault < 4; ++fault) {
    PathTracker tracker(params);
    tracker.follow(Path(bend(), params.limits), std::nullopt);
    Plant plant({}, {});
    TrackerOutput before;
    for (int i = 0; i < 30; ++i) {
      before = tracker.step(plant.state().stamp, plant.state());
      plant.move(before.command, kPeriodS);
    }
    ASSERT_GT(before.command.speed_mps, 0.3);
    BaseState bad = plant.state();
    if (fault == 0) bad.p_map_m.x() = nan;
    if (fault == 1) bad.twist.turn_rate_radps = nan;
    if (fault == 2) bad.stamp -= from_seconds(1.0);
    if (fault == 3) bad.p_map_m.y() += 2;
    const TrackerOutput output = tracker.step(plant.state().stamp, bad);
    EXPECT_EQ(output.mode, TrackerMode::kBrake);
    EXPECT_FALSE(output.reason.empty());
    EXPECT_NEAR(output.command.speed_mps, before.command.speed_mps - params.limits.max_acceleration_mps2 * kPeriodS,
                1e-9);
    plant.move(output.command, kPeriodS);
    EXPECT_EQ(drive(tracker, plant, {.max_acceleration_mps2 = 100}).mode, TrackerMode::kArrived) << "it recovers";
  }
}

TEST(PathTracker, NoStateWhateverBreaksALimit) {
  const TrackerParams params;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  PathTracker tracker(params);
  Twist2 last;
  Time now;
  for (int i = 0; i < 30000; ++i) {
    if (i % 500 == 0) tracker.follow(Path(bend(), params.limits), std::nullopt);
    BaseState state;
    now += from_seconds(kPeriodS);
    state.stamp = now - from_seconds(std::abs(0.1 * normal(random)));
    const double scale = i % 7 == 0 ? 1e6 : 0.3;
    state.p_map_m = Eigen::Vector2d(1 + scale * normal(random), scale * normal(random));
    state.yaw_rad = scale * normal(random);
    state.twist = {scale * normal(random), scale * normal(random)};
    const Twist2 command = tracker.step(now, state).command;
    ASSERT_LE(std::abs(command.speed_mps), params.limits.max_speed_mps);
    ASSERT_LE(std::abs(command.turn_rate_radps), params.limits.max_turn_rate_radps);
    ASSERT_LE(std::abs(command.speed_mps - last.speed_mps), params.limits.max_acceleration_mps2 * kPeriodS + 1e-9);
    ASSERT_LE(std::abs(command.turn_rate_radps - last.turn_rate_radps),
              params.limits.max_turn_acceleration_radps2 * kPeriodS + 1e-9);
    last = command;
  }
}

TEST(PathTracker, StopEndsTheMotionSmoothly) {
  const TrackerParams params;
  PathTracker tracker(params);
  tracker.follow(Path(bend(), params.limits), std::nullopt);
  Plant plant({}, {});
  for (int i = 0; i < 30; ++i) plant.move(tracker.step(plant.state().stamp, plant.state()).command, kPeriodS);
  tracker.stop();
  double before = plant.state().twist.speed_mps;
  for (int i = 0; i < 40; ++i) {
    const TrackerOutput output = tracker.step(plant.state().stamp, plant.state());
    EXPECT_EQ(output.mode, TrackerMode::kIdle);
    EXPECT_LE(output.command.speed_mps, before + 0.05);
    before = output.command.speed_mps;
    plant.move(output.command, kPeriodS);
  }
  EXPECT_LT(std::abs(plant.state().twist.speed_mps), 1e-3);
}

TEST(PathTracker, WhoeverStopsInABendStaysOnItsArc) {
  const TrackerParams params;
  for (const bool forgets : {true, false}) {
    PathTracker tracker(params);
    tracker.follow(Path(bend(), params.limits), std::nullopt);
    Plant plant({}, {});
    while (plant.state().yaw_rad < 0.5) plant.move(tracker.step(plant.state().stamp, plant.state()).command, kPeriodS);
    const BaseState begin = plant.state();
    ASSERT_GT(begin.twist.turn_rate_radps, 0.3);
    const double radius = begin.twist.speed_mps / begin.twist.turn_rate_radps;
    const Eigen::Vector2d centre =
        begin.p_map_m + radius * Eigen::Vector2d(-std::sin(begin.yaw_rad), std::cos(begin.yaw_rad));
    if (forgets) tracker.stop();
    for (int i = 0; i < 40; ++i) {
      const Time now = plant.state().stamp;
      plant.move((forgets ? tracker.step(now, plant.state()) : tracker.brake(now, "told to")).command, kPeriodS);
      ASSERT_NEAR((plant.state().p_map_m - centre).norm(), radius, 0.01);
    }
    EXPECT_LT(std::abs(plant.state().twist.speed_mps), 1e-3);
    EXPECT_GT((plant.state().p_map_m - begin.p_map_m).norm(), 0.15) << "straight on would be 2 cm off the arc";
  }
}

TEST(PathTracker, ANewPathInABendIsTakenWithoutStopping) {
  const TrackerParams params;
  PathTracker tracker(params);
  tracker.follow(Path(bend(), params.limits), std::nullopt);
  Plant plant({}, {});
  while (plant.state().yaw_rad < 0.5) plant.move(tracker.step(plant.state().stamp, plant.state()).command, kPeriodS);
  ASSERT_GT(plant.state().twist.turn_rate_radps, 0.3);
  const double before = plant.state().twist.speed_mps;
  for (int i = 0; i < 10; ++i) {
    const BaseState& at = plant.state();
    const Eigen::Vector2d ahead(std::cos(at.yaw_rad), std::sin(at.yaw_rad));
    tracker.follow(Path({at.p_map_m, at.p_map_m + 2 * ahead}, params.limits), std::nullopt);
    const TrackerOutput output = tracker.step(at.stamp, at);
    EXPECT_EQ(output.mode, TrackerMode::kTrack);
    EXPECT_GT(output.command.speed_mps, 0.8 * before);
    plant.move(output.command, kPeriodS);
  }
}

TEST(PathTracker, AStepThatComesEarlyChangesLess) {
  const TrackerParams params;
  PathTracker tracker(params);
  tracker.follow(Path(bend(), params.limits), std::nullopt);
  BaseState state;
  const double first = tracker.step(state.stamp, state).command.speed_mps;
  state.stamp += from_seconds(0.01);
  const double second = tracker.step(state.stamp, state).command.speed_mps;
  EXPECT_LE(second - first, 0.01 * params.limits.max_acceleration_mps2 + 1e-12);
}

TEST(PathTracker, AfterAHaltItStartsFromZeroAndABrakeKeepsThePath) {
  const TrackerParams params;
  PathTracker tracker(params);
  tracker.follow(Path(bend(), params.limits), std::nullopt);
  Plant plant({}, {});
  for (int i = 0; i < 30; ++i) plant.move(tracker.step(plant.state().stamp, plant.state()).command, kPeriodS);
  const TrackerOutput braking = tracker.brake(plant.state().stamp, "told to");
  EXPECT_EQ(braking.mode, TrackerMode::kBrake);
  EXPECT_EQ(braking.reason, "told to");
  EXPECT_LT(braking.command.speed_mps, plant.state().twist.speed_mps);
  tracker.halt();
  const TrackerOutput output = tracker.step(plant.state().stamp, plant.state());
  EXPECT_EQ(output.mode, TrackerMode::kTrack);
  EXPECT_LE(output.command.speed_mps, params.limits.max_acceleration_mps2 * params.period_s + 1e-12);
}

TEST(PathTracker, ImpossibleParametersAreOneClearError) {
  TrackerParams params;
  params.period_s = -1;
  EXPECT_THROW(PathTracker{params}, InputError);
}

}  // namespace
}  // namespace arpent::control
