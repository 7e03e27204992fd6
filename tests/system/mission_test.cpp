// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// Whole simulated missions in lockstep: the same seed gives the same bytes, the log replays to what it says, and what
// cannot be run is one clear error.
#include <gtest/gtest.h>

#include <filesystem>

#include "common/atomic_file.h"
#include "common/error.h"
#include "planning/viewpoints/certificate_file.h"
#include "tools/mission/figures.h"
#include "tools/replay/replay.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
const fs::path kConfig = ARPENT_SOURCE_DIR "/config";

class MissionTest : public testing::Test {
 protected:
  ~MissionTest() override { fs::remove_all(folder_); }

  MissionSpec square(int seed, const std::vector<std::string>& settings) const {
    MissionOverrides overrides;
    overrides.seed = seed;
    overrides.settings = settings;
    return load_mission(kConfig / "missions/square.yaml", overrides);
  }
  MissionResult run(const MissionSpec& spec, int threads = 2) const {
    MissionOptions options;
    options.out = folder_;
    options.threads = threads;
    options.progress = false;
    return run_mission(spec, options);
  }

  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("mission_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

/// One small lap: about 11 m.
const std::vector<std::string> kShort{"mission.loop.laps=1", "mission.loop.size_m=[2,1.6]",
                                      "mission.loop.centre_m=[3.5,1.8]", "mission.loop.entry_m=[3.5,1.0]"};

TEST_F(MissionTest, ALapIsDrivenOnItsOwnPoseAndItsLogReplaysByteForByte) {
  const MissionResult result = run(square(1, kShort));
  ASSERT_TRUE(result.done()) << (result.reports.empty() ? "" : result.reports.back().reason);
  const MissionFigures figures = measure(result);
  EXPECT_EQ(figures.collisions, 0);
  EXPECT_GT(figures.path_m, 8);
  EXPECT_LT(figures.ate_m, 0.05);
  EXPECT_LT(figures.yaw_error_deg, 1.0);
  EXPECT_LT(figures.worst_off_path_m, 0.15);
  EXPECT_GT(result.mesh.triangles.size(), 2000U);

  const ReplayInput input = open_log(result.log, folder_ / "replay", "", {});
  EXPECT_TRUE(input.drive);
  const ReplayResult replayed = run_lockstep(input, {});
  const LogComparison comparison = compare_with_log(input, replayed);
  EXPECT_GT(comparison.compared, 1000);
  EXPECT_EQ(comparison.different + comparison.further, 0);
}

TEST_F(MissionTest, PerceptionMayBelieveInAnotherRigThanTheCamerasOfTheWorldHave) {
  const MissionSpec own = square(1, {});
  EXPECT_EQ(own.depth.rig.filename(), "wifibot_stereo.yaml");
  MissionOverrides overrides;
  overrides.rig = "believed.yaml";
  const MissionSpec spec = load_mission(kConfig / "missions/square.yaml", overrides);
  for (const auto& rig : {spec.depth.rig, spec.odometry.rig, spec.tags.rig, spec.mapping.rig, spec.mission.rig}) {
    EXPECT_EQ(rig, fs::absolute("believed.yaml"));
  }
  EXPECT_EQ(spec.sim.robot, own.sim.robot) << "whose rig file the simulator loads by itself";
}

TEST_F(MissionTest, TheSameSeedGivesTheSameBytesWithAnyNumberOfThreads) {
  std::vector<std::string> brief = kShort;
  brief.emplace_back("mission.max_time_s=6");
  const MissionResult first = run(square(3, brief), 1);
  EXPECT_EQ(first.log_crc, run(square(3, brief), 2).log_crc);
  EXPECT_NE(first.log_crc, run(square(4, brief), 1).log_crc);
  EXPECT_EQ(first.reports.back().state, planning::MissionState::kAborted);
  EXPECT_NE(first.reports.back().reason.find("max_time_s"), std::string::npos);
}

TEST_F(MissionTest, WithDepthInsteadOfImagesTheSameMissionRuns) {
  MissionSpec spec = square(1, kShort);
  spec.sensing = spec.sim.sensing = "depth";
  const MissionResult result = run(spec);
  EXPECT_TRUE(result.done());
  EXPECT_EQ(result.collisions, 0);
  EXPECT_LT(measure(result).ate_m, 0.15);
}

TEST_F(MissionTest, ARobotExploresByItselfWithoutTouchingAnything) {
  MissionOverrides overrides;
  overrides.settings = {"mission.max_time_s=40"};
  overrides.sensing = "depth";
  const MissionResult result = run(load_mission(kConfig / "missions/test_arena.yaml", overrides));
  EXPECT_EQ(result.collisions, 0);
  EXPECT_GT(measure(result).path_m, 1.0);
  ASSERT_FALSE(result.reports.empty());
  EXPECT_GT(result.reports.back().progress, 0.4);
}

/// Silent cameras, lost odometry, something new in the way: the robot waits or drives around, and finishes its job.
TEST_F(MissionTest, ARobotGoesOnAfterWhatGoesWrongAndTouchesNothing) {
  MissionOverrides overrides;
  overrides.sensing = "depth";
  overrides.settings = {"sim.faults.obstacle_at_s=12", "sim.faults.obstacle=[1.5,5.0,0.3]", "sim.faults.silent_at_s=25",
                        "sim.faults.blind_at_s=40"};
  const MissionResult result = run(load_mission(kConfig / "missions/test_arena.yaml", overrides));
  EXPECT_TRUE(result.done()) << (result.reports.empty() ? "" : result.reports.back().reason);
  EXPECT_EQ(result.collisions, 0);
  EXPECT_GT(result.reports.back().progress, 0.9);
}

/// A room of 3.5 x 3 m without a door, in a region that is larger.
constexpr const char* kClosedRoom = R"(name: closed
region: {min_m: [-2, -2, 0], max_m: [6, 5, 1.5]}
textures: {all: {kind: concrete}}
surfaces:
  - plane: {corner_m: [-2, -2, 0], u_m: [8, 0, 0], v_m: [0, 7, 0], texture: all}
  - box: {centre_m: [-0.1, 1.5, 0.75], size_m: [0.2, 3.4, 1.5], texture: all}
  - box: {centre_m: [3.6, 1.5, 0.75], size_m: [0.2, 3.4, 1.5], texture: all}
  - box: {centre_m: [1.75, -0.1, 0.75], size_m: [3.5, 0.2, 1.5], texture: all}
  - box: {centre_m: [1.75, 3.1, 0.75], size_m: [3.5, 0.2, 1.5], texture: all}
lighting: {ambient: 1}
starts: [{x_m: 1.0, y_m: 1.5, yaw_rad: 0}]
)";

TEST_F(MissionTest, BehindAClosedDoorIsNothingToWaitFor) {
  fs::create_directories(folder_);
  atomic_write(folder_ / "closed.yaml", kClosedRoom);
  MissionOverrides overrides;
  overrides.sensing = "depth";
  overrides.world = folder_ / "closed.yaml";
  const MissionResult result = run(load_mission(kConfig / "missions/test_arena.yaml", overrides));
  EXPECT_TRUE(result.done()) << (result.reports.empty() ? "" : result.reports.back().reason);
  EXPECT_EQ(result.collisions, 0);
  EXPECT_GT(measure(result).path_m, 1.0);
  EXPECT_GT(result.mesh.triangles.size(), 2000U);
}

TEST_F(MissionTest, AnExplorationLeavesACertificateAndReplaysByteForByte) {
  MissionOverrides overrides;
  overrides.settings = {"mission.max_time_s=12"};
  const MissionResult result = run(load_mission(kConfig / "missions/test_arena.yaml", overrides));
  const auto certificate = planning::read_certificates(folder_ / "certificate.json");
  EXPECT_EQ(certificate.context.end, "aborted");
  EXPECT_NE(certificate.context.reason.find("max_time_s"), std::string::npos);
  EXPECT_GT(certificate.elements.size(), 20U);
  EXPECT_FALSE(certificate.context.poses.empty());
  const ReplayInput input = open_log(result.log, folder_ / "replay", "", {});
  const LogComparison comparison = compare_with_log(input, run_lockstep(input, {}));
  EXPECT_GT(comparison.compared, 500);
  EXPECT_EQ(comparison.different + comparison.further, 0);
}

TEST(Missions, APresetIsASetOfParametersThatSettingsStillOverride) {
  MissionOverrides overrides;
  overrides.preset = "thesis";
  overrides.settings = {"depth.rate_hz=2"};
  const MissionSpec spec = load_mission(kConfig / "missions/test_arena.yaml", overrides);
  EXPECT_EQ(spec.mission.explore.viewpoints.preset, "thesis");
  EXPECT_EQ(spec.mission.explore.tour.objective, "utility");
  EXPECT_EQ(spec.mission.explore.low_level.leg.planner, "lazy_prm");
  EXPECT_EQ(spec.depth.rate_hz, 2);
  overrides.preset = "best";
  EXPECT_THROW((void)load_mission(kConfig / "missions/test_arena.yaml", overrides), InputError);
}

TEST_F(MissionTest, WhatCannotBeRunIsOneClearError) {
  const auto fault = [&](const std::vector<std::string>& settings) -> std::string {
    try {
      (void)run(square(1, settings));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(fault({"start=9"}).find("no start 9"), std::string::npos);
  EXPECT_NE(fault({"mission.loop.corner_radius_m=5"}).find("corner_radius_m"), std::string::npos);
  EXPECT_NE(fault({"mission.kind=fly"}).find("kind"), std::string::npos);
  EXPECT_NE(fault({"sim.motors.left_slip=2"}).find("left_slip"), std::string::npos);
  EXPECT_NE(fault({"world=/nowhere.yaml"}).find("nowhere"), std::string::npos);
  fs::create_directories(folder_);
  const fs::path robot = folder_ / "robot.yaml";
  atomic_write(robot, "name: r\nrig: " + (kConfig / "rigs/wifibot_stereo.yaml").string() + "\nbase: {track_m: -0.4}\n");
  EXPECT_NE(fault({"robot=" + robot.string()}).find("track_m"), std::string::npos);
}

TEST(Missions, EveryShippedMissionLoads) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(kConfig / "missions")) {
    EXPECT_NO_THROW((void)load_mission(entry.path(), {})) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 3);
}

}  // namespace
}  // namespace arpent::tools
