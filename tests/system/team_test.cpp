// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// A team in lockstep: its first seconds are the same with any number of threads, everybody's map grows by what others
// saw, nobody takes a teammate for surface, and what cannot be run is one clear error.
#include <gtest/gtest.h>

#include <arpent/map_patch_t.hpp>
#include <filesystem>
#include <set>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/log/event_log.h"
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

TEST_F(TeamMissionTest, ARobotThatJoinsLateKnowsWhatOthersSawAndIsGivenWork) {
  MissionSpec spec = arena(2, 24);
  spec.join = "R2@7";
  const TeamResult result = run(spec);
  ASSERT_FALSE(result.robots[1].truth.empty());
  EXPECT_GT(result.robots[1].truth.front().stamp - result.robots[0].truth.front().stamp, std::chrono::seconds(6));
  EXPECT_GT(result.robots[1].paths.size(), 1U) << "it was sent somewhere";
  EXPECT_GT(result.processes.at("R2/mission_process").counters.at("TEAM_PATCH.received"), 20) << "also those of before";
  EXPECT_EQ(result.encounters.overlaps, 0);
}

TEST_F(TeamMissionTest, ACentreThatIsStartedAgainGoesOnFromItsJournalAndGetsWhatItMissed) {
  MissionSpec spec = arena(2, 18);
  spec.patch.send_again_s = 4;
  spec.kill = "centre@8";
  spec.join = "centre@11";
  const TeamResult result = run(spec);
  const auto& counters = result.processes.at("centre/centre_process").counters;
  EXPECT_GT(counters.at("TEAM_PATCH.recalled"), 20);
  EXPECT_GT(counters.at("TOUR.recalled"), 2);
  std::int64_t again = 0, expired = 0;
  for (const char* robot : {"R1", "R2"}) {
    const auto& patches = result.processes.at(std::string(robot) + "/patch_process").counters;
    if (patches.contains("MAP_PATCH.sent_again")) again += patches.at("MAP_PATCH.sent_again");
    const auto& mission = result.processes.at(std::string(robot) + "/mission_process").counters;
    expired += mission.contains("TEAM_TOUR.expired") ? mission.at("TEAM_TOUR.expired") : 0;
  }
  EXPECT_GT(again, 0);
  EXPECT_EQ(expired, 0);
  // Everything that the robots have sent, but for the newest, is in the new centre's map.
  std::set<std::pair<std::string, std::int64_t>> sent;
  for (const char* robot : {"R1", "R2"}) {
    LogReader log(folder_ / robot / "mission.lcmlog");
    map_patch_t patch;
    std::string fault;
    while (const auto event = log.next()) {
      if (event->channel != channels::kMapPatch) continue;
      ASSERT_TRUE(decode_guarded(event->data, patch, fault)) << fault;
      sent.emplace(patch.source, patch.sample);
    }
  }
  EXPECT_GE(result.centre.patches, static_cast<std::int64_t>(sent.size()) - 20);
  EXPECT_LE(result.centre.patches, static_cast<std::int64_t>(sent.size()));
}

TEST_F(TeamMissionTest, TeamsThatCannotBeAreOneClearError) {
  EXPECT_THROW((void)run(arena(4, 10)), InputError) << "the arena has three starts";
  MissionSpec spec = arena(2, 10);
  spec.join = "centre@5";
  EXPECT_THROW((void)joins(spec), InputError) << "it was not killed";
  spec.join = "R5@5";
  EXPECT_THROW((void)joins(spec), InputError);
  for (const char* kill : {"R3@5", "R2", "R2@x", "R2@-1", "R2@5s"}) {
    EXPECT_THROW((void)deaths(arena(2, 10, kill)), InputError) << kill;
  }
  EXPECT_EQ(deaths(arena(2, 10, "R1@2.5,R2@4")).size(), 2U);
}

}  // namespace
}  // namespace arpent::tools
