// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The mission file (config/missions): which world or robot, where from, what to do, and whatever shall differ from the
// processes' defaults. docs/missions.md describes it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "control/process/tracker_process.h"
#include "drivers/base/process/base_driver_process.h"
#include "mapping/process/mapping_process.h"
#include "mapping/process/patch_process.h"
#include "perception/process/depth_process.h"
#include "perception/process/odometry_process.h"
#include "perception/process/pose_process.h"
#include "perception/process/tag_process.h"
#include "planning/process/centre_process.h"
#include "planning/process/mission_process.h"
#include "sim/process/radio_process.h"
#include "sim/process/sim_process.h"

namespace arpent::tools {

/// What a simulated mission consists of.
struct MissionSpec {
  std::string name = "mission";
  std::filesystem::path world;
  std::filesystem::path robot;
  int start = 0;
  int seed = 1;
  std::string sensing = "images";
  bool use_region = true;
  int robots = 1;
  std::string kill, join;
  SimConfig sim;
  BaseDriverConfig base;
  DepthConfig depth;
  OdometryConfig odometry;
  TagConfig tags;
  PoseConfig pose;
  TrackerConfig tracker;
  MappingConfig mapping;
  MissionConfig mission;
  PatchConfig patch;
  CentreConfig centre;
  RadioConfig radio;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("name", self.name, "name of the mission");
    visitor.field("world", self.world, "world file to simulate", config::required_path());
    visitor.field("robot", self.robot, "robot file", config::required_path());
    visitor.field("start", self.start, "which of the world's starts, from 0", config::at_least(0));
    visitor.field("seed", self.seed, "seed of all simulated noise", config::at_least(0));
    visitor.field("sensing", self.sensing, "images: cameras and all perception; depth: for missions about planning",
                  config::one_of({"images", "depth"}));
    visitor.field("use_region", self.use_region, "explore only the world's region");
    visitor.field("robots", self.robots, "how many robots, from the world's starts one after the other",
                  config::between(1, 5));
    visitor.field("kill", self.kill,
                  "ROBOT@SECONDS: that robot's computer dies then; with commas between, several; centre@SECONDS: the "
                  "centre does");
    visitor.field("join", self.join,
                  "ROBOT@SECONDS: that robot is there only from then on; centre@SECONDS: the centre that was killed is "
                  "started again and goes on from its journal");
    visitor.group("sim", self.sim, "sim_process");
    visitor.group("base", self.base, "base_driver_process");
    visitor.group("depth", self.depth, "depth_process");
    visitor.group("odometry", self.odometry, "odometry_process");
    visitor.group("tags", self.tags, "tag_process");
    visitor.group("pose", self.pose, "pose_process");
    visitor.group("tracker", self.tracker, "tracker_process");
    visitor.group("mapping", self.mapping, "mapping_process");
    visitor.group("mission", self.mission, "mission_process");
    visitor.group("patch", self.patch, "patch_process (a team)");
    visitor.group("centre", self.centre, "centre_process (a team)");
    visitor.group("radio", self.radio, "radio_process (a team)");
  }
};

/// What the command line says on top of the file.
struct MissionOverrides {
  std::filesystem::path world;
  std::filesystem::path rig;  ///< what perception believes in, while the simulator keeps the robot's own
  std::optional<int> seed;
  std::string sensing;
  std::string preset;  ///< default or thesis; empty: as the file has it
  std::optional<int> robots;
  std::string kill, join;
  std::vector<std::string> settings;  ///< key=value
};

/// Reads and completes a mission: every process gets its robot, rig, world and cube. Throws InputError.
[[nodiscard]] MissionSpec load_mission(const std::filesystem::path& file, const MissionOverrides& overrides);

/// R1, R2, and so on.
[[nodiscard]] std::vector<std::string> robot_names(const MissionSpec& spec);

/// The spec of one robot of a team, by its number from 0: its start, its seed, and that it is led.
[[nodiscard]] MissionSpec spec_of_robot(const MissionSpec& team, int robot);

/// The centre's name among those of the robots.
inline constexpr char kCentre[] = "centre";

struct TeamEvent {
  std::string who;  ///< a robot, or the centre
  double at_s = 0;  ///< after the start of the mission
};
/// Of `kill` and `join`. Throw InputError if they make no sense.
[[nodiscard]] std::vector<TeamEvent> deaths(const MissionSpec& spec);
[[nodiscard]] std::vector<TeamEvent> joins(const MissionSpec& spec);

}  // namespace arpent::tools
