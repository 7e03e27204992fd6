// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// A team in lockstep: its first seconds are the same with any number of threads, everybody's map grows by what others
// saw, nobody takes a teammate for surface, and what cannot be run is one clear error.
#include <gtest/gtest.h>

#include <filesystem>

#include "common/error.h"
#include "tools/mission/team_figures.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
const fs::path kConfig = ARPENT_SOURCE_DIR "/config";

class TeamMissionTest : public testing::Test {
 protected:
  ~TeamMissionTest() override { fs::remove_all(folder_); }

  static MissionSpec arena(int robots, double max_time_s, const std::string& kill = "") {
    MissionOverrides overrides;
    overrides.sensing = "depth";
    overrides.robots = robots;
    overrides.kill = kill;
    overrides.settings = {"mission.max_time_s=" + std::to_string(max_time_s)};
    return load_mission(kConfig / "missions/test_arena.yaml", overrides);
  }
  TeamResult run(const MissionSpec& spec, int threads = 2) const {
    MissionOptions options;
    options.out = folder_;
    options.threads = threads;
    options.progress = false;
    return run_team(spec, options);
  }

  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("team_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(TeamMissionTest, TheFirstSecondsOfTwoRobotsAreTheSameWithAnyNumberOfThreads) {
  const MissionSpec spec = arena(2, 10);
  const TeamResult first = run(spec, 1), second = run(spec, 2);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(first.robots[i].log_crc, second.robots[i].log_crc) << first.names[i];
    EXPECT_GT(second.robots[i].paths.size(), 1U) << "it was sent somewhere";
    EXPECT_EQ(second.robots[i].collisions, 0);
    EXPECT_TRUE(fs::exists(folder_ / second.names[i] / "mission.lcmlog"));
  }
  EXPECT_EQ(second.encounters.overlaps, 0);
  EXPECT_GT(second.centre.patches, 10);
  EXPECT_GT(second.centre.plans, 2);
  for (const char* channel : {"TEAM_PATCH", "TEAM_STATE", "TEAM_TOUR"}) {
    EXPECT_GT(second.radio_bytes.at(channel), 1000) << channel;
  }
  // The second start looks past the first robot: what it hides is neither surface nor free.
  EXPECT_GT(second.processes.at("R2/patch_process").counters.at("MASK.pixels") +
                second.processes.at("R1/patch_process").counters.at("MASK.pixels"),
            0);
}

TEST_F(TeamMissionTest, ARobotThatDiesIsMissedAndStandsWhereItDied) {
  const TeamResult result = run(arena(2, 10, "R2@5"));
  EXPECT_EQ(result.died, std::vector<std::string>{"R2"});
  EXPECT_EQ(result.centre.lost, 1);
  ASSERT_FALSE(result.robots[1].truth.empty());
  EXPECT_GT(result.robots[1].truth.back().stamp - result.robots[1].truth.front().stamp, std::chrono::seconds(9))
      << "its body is still there";
  EXPECT_LT(result.robots[1].reports.back().stamp - result.robots[1].reports.front().stamp, std::chrono::seconds(6));
}

TEST_F(TeamMissionTest, TeamsThatCannotBeAreOneClearError) {
  EXPECT_THROW((void)run(arena(4, 10)), InputError) << "the arena has three starts";
  for (const char* kill : {"R3@5", "R2", "R2@x", "R2@-1", "R2@5s"}) {
    EXPECT_THROW((void)deaths(arena(2, 10, kill)), InputError) << kill;
  }
  EXPECT_EQ(deaths(arena(2, 10, "R1@2.5,R2@4")).size(), 2U);
}

}  // namespace
}  // namespace arpent::tools
