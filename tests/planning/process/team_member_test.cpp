// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The team's side of a robot whose way a teammate bars: it stops once and asks for room; and of one that has arrived.
#include "planning/process/team_member.h"

#include <gtest/gtest.h>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "planning/team/wire.h"

namespace arpent {
namespace {

using namespace std::chrono_literals;
using planning::MissionState;

class TeamMemberTest : public testing::Test {
 protected:
  TeamMemberTest() {
    executor_.set_tap([this](Time, const std::string& channel, BytesView bytes) {
      robot_state_t message;
      std::string fault;
      if (channel != channels::kRobotState || !decode_guarded(bytes, message, fault)) return;
      blocked_by_ = message.blocked_by;
      sent_points_ = message.path_count;
    });
    const auto [bus, clock] = executor_.add_process("test");
    TeamMemberParams params;
    params.robot = "R1";
    planning::ExplorerParams explore;
    explore.led = true;
    explorer_ = std::make_unique<planning::Explorer>(explore, planning::LevelCamera{});
    member_ = std::make_unique<TeamMember>(params, explore.footprint, *explorer_, bus, clock);
  }

  /// A tenth of a second, in which the teammate says that it stands there. True if the robot had to stop.
  bool step(const Pose2& mate) {
    planning::RobotState state;
    state.stamp = executor_.now();
    state.robot = "R2";
    state.state = MissionState::kRunning;
    state.body = mate;
    executor_.inject(executor_.now(), channels::kTeamState, encode(planning::to_wire(state)));
    executor_.run_until(executor_.now() + 100ms);
    return member_->step(MissionState::kRunning, executor_.now(), here_, {}, 0.01);
  }
  bool may_drive() { return member_->may_drive(here_, {{{0, 0}, {2, 0}}, {}, false}); }

  Pose2 here_{0, 0, 0};
  static constexpr Pose2 kInTheWay{1.2, 0, 0}, kElsewhere{8, 0, 0};
  LockstepExecutor executor_{Time(100s)};
  std::unique_ptr<planning::Explorer> explorer_;
  std::unique_ptr<TeamMember> member_;
  std::string blocked_by_;
  int sent_points_ = -1;
};

TEST_F(TeamMemberTest, AWayThatWasRefusedDoesNotStopItAgain) {
  (void)step(kInTheWay);
  ASSERT_FALSE(may_drive());
  int stops = 0;
  for (int i = 0; i < 40; ++i) stops += step(kInTheWay) ? 1 : 0;
  EXPECT_EQ(stops, 1) << "the planner, which looks five times a second, would never find it free";
  ASSERT_FALSE(may_drive());
  for (int i = 0; i < 10; ++i) (void)step(kElsewhere);
  EXPECT_TRUE(may_drive());
}

TEST_F(TeamMemberTest, WhoIsRefusedAgainAndAgainAsksForRoom) {
  (void)step(kInTheWay);
  for (int refused = 1; refused <= 3; ++refused) {
    EXPECT_EQ(blocked_by_, "") << refused;
    ASSERT_FALSE(may_drive());
    for (int i = 0; i < 10; ++i) (void)step(kInTheWay);
  }
  EXPECT_EQ(blocked_by_, "R2");
  for (int i = 0; i < 10; ++i) (void)step(kElsewhere);
  EXPECT_TRUE(may_drive());
  for (int i = 0; i < 2; ++i) (void)step(kElsewhere);
  EXPECT_EQ(blocked_by_, "");
}

/// Teammates would wait for a robot that stands at the end of its way.
TEST_F(TeamMemberTest, AWayThatIsDrivenIsSentNoLonger) {
  (void)step(kElsewhere);
  ASSERT_TRUE(may_drive());
  for (int i = 0; i < 2; ++i) (void)step(kElsewhere);
  EXPECT_EQ(sent_points_, 2);
  here_ = {1.95, 0.02, 0};
  for (int i = 0; i < 2; ++i) (void)step(kElsewhere);
  EXPECT_EQ(sent_points_, 0);
}

}  // namespace
}  // namespace arpent
