// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// Encounters of true ways whose stamps differ, against distances and moments that are known by construction.
#include "tools/mission/encounters.h"

#include <gtest/gtest.h>

#include "common/pose2.h"

namespace arpent::tools {
namespace {

using namespace std::chrono_literals;
using evaluation::Trajectory;

constexpr double kLongM = 0.5, kShortM = 0.25;

RobotConfig robot() {
  RobotConfig robot;
  robot.semi_axis_long_m = kLongM;
  robot.semi_axis_short_m = kShortM;
  return robot;
}

/// At 50 Hz for `seconds`, from x = `x_m`, beginning at `offset`.
Trajectory way(double x_m, double y_m, double speed_mps, double seconds, Duration offset = Duration(0)) {
  Trajectory way;
  for (int i = 0; i <= static_cast<int>(50 * seconds); ++i) {
    const Duration since = offset + i * Duration(20ms);
    way.push_back({Time(100s) + since, Pose2{x_m + speed_mps * to_seconds(since), y_m, 0}.to_pose()});
  }
  return way;
}

TEST(Encounters, TheGapOfStandingRobotsIsThatBetweenTheirEllipses) {
  const TeamEncounters found = encounters_of(robot(), {way(0, 0, 0, 2), way(0, 1.0, 0, 2, 7ms), way(9, 9, 0, 2)});
  EXPECT_EQ(found.overlaps, 0);
  EXPECT_NEAR(found.least_gap_m, 1.0 - 2 * kShortM, kShortM / 5);
}

/// The second drives through the first and on: from centre distance +2 m to -2 m in 4 s.
TEST(Encounters, APassThroughAnotherIsOneOverlapWhateverTheStamps) {
  for (const Duration offset : {0ms, 3ms, 11ms, 19ms}) {
    const TeamEncounters found = encounters_of(robot(), {way(0, 0, 0, 4), way(2, 0, -1, 4, offset)});
    EXPECT_EQ(found.overlaps, 1);
    EXPECT_LT(found.least_gap_m, 0);
  }
}

/// One pose a second and 1 m apart: only between the stamps they are side by side, and the gap is that moment's.
TEST(Encounters, BetweenStampsARobotMovesEvenly) {
  Trajectory sparse;
  for (int i = 0; i <= 4; ++i) sparse.push_back({Time(100s + i * 1s), Pose2{-2.5 + i, 0.8, 0}.to_pose()});
  const TeamEncounters found = encounters_of(robot(), {way(0, 0, 0, 4), sparse});
  EXPECT_NEAR(found.least_gap_m, 0.8 - 2 * kShortM, kShortM / 5);
}

TEST(Encounters, WaysThatDoNotShareATimeNeverMeet) {
  const TeamEncounters found = encounters_of(robot(), {way(0, 0, 0, 1), way(0, 0, 0, 1, 5s), {}});
  EXPECT_EQ(found.overlaps, 0);
  EXPECT_EQ(found.least_gap_m, TeamEncounters{}.least_gap_m);
}

}  // namespace
}  // namespace arpent::tools
