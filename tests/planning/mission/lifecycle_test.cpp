// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/lifecycle.h"

#include <gtest/gtest.h>

namespace arpent::planning {
namespace {

TEST(MissionLifecycle, GoesFromWaitingThroughAligningAndRunningToDone) {
  Lifecycle mission;
  mission.aligned();
  EXPECT_EQ(mission.state(), MissionState::kWaiting) << "nothing begins before the start";
  EXPECT_FALSE(mission.command(MissionCommand::kStart, "test"));
  EXPECT_EQ(mission.state(), MissionState::kAligning);
  mission.aligned();
  EXPECT_EQ(mission.state(), MissionState::kRunning);
  mission.finish();
  EXPECT_EQ(mission.state(), MissionState::kDone);
}

TEST(MissionLifecycle, APauseGoesOnWhereItWas) {
  Lifecycle mission;
  (void)mission.command(MissionCommand::kStart, "test");
  EXPECT_FALSE(mission.command(MissionCommand::kPause, "console"));
  EXPECT_EQ(mission.reason(), "paused by console");
  mission.aligned();
  EXPECT_EQ(mission.state(), MissionState::kPaused);
  EXPECT_FALSE(mission.command(MissionCommand::kResume, "console"));
  EXPECT_EQ(mission.state(), MissionState::kAligning);
}

TEST(MissionLifecycle, CommandsOutOfPlaceAreRefusedWithASentenceAndChangeNothing) {
  Lifecycle mission;
  for (const auto command : {MissionCommand::kPause, MissionCommand::kResume}) {
    const auto refused = mission.command(command, "test");
    ASSERT_TRUE(refused);
    EXPECT_NE(refused->find("the mission is waiting"), std::string::npos);
  }
  EXPECT_TRUE(mission.command(static_cast<MissionCommand>(9), "test"));
  EXPECT_EQ(mission.state(), MissionState::kWaiting);
}

TEST(MissionLifecycle, AnEndedMissionStaysEnded) {
  Lifecycle mission;
  (void)mission.command(MissionCommand::kStart, "test");
  EXPECT_FALSE(mission.command(MissionCommand::kAbort, "console"));
  EXPECT_EQ(mission.reason(), "aborted by console");
  mission.finish();
  mission.abort("again");
  EXPECT_EQ(mission.state(), MissionState::kAborted);
  EXPECT_EQ(mission.reason(), "aborted by console");
  EXPECT_TRUE(mission.command(MissionCommand::kStart, "test"));
}

}  // namespace
}  // namespace arpent::planning
