// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/mission_file.h"

#include <algorithm>
#include <sstream>

#include "common/config/robot.h"
#include "common/error.h"
#include "common/split.h"
#include "sim/world/world.h"

namespace arpent::tools {
namespace {

/// Paths that the processes ask for and the mission fills in: not empty, so that the file need not name them.
const char* const kFilledIn = "-";
/// Between the seeds of a team's robots.
constexpr int kSeedStep = 1000;
/// Of a base's deceleration, what its stops on a path may need: the tracker uses 0.9, the rest is for delays.
constexpr double kShareOfBrakes = 0.7;

tags::TagCubeConfig to_config(const sim::TagCube& cube) {
  tags::TagCubeConfig config;
  config.x_m = cube.centre_m.x();
  config.y_m = cube.centre_m.y();
  config.z_m = cube.centre_m.z();
  config.yaw_rad = cube.yaw_rad;
  config.edge_m = cube.edge_m;
  config.tag_m = cube.tag_m;
  config.ids.assign(cube.ids.begin(), cube.ids.end());
  return config;
}

/// The world's; wider by half a voxel on the ground, as walls on its border may come out a little beyond.
template <class Params>
void set_region(const sim::Region& region, Params& explore) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const double margin_m = i < 2 ? 0.6 * explore.tsdf.voxel_m : 0.0;
    explore.region_min_m[i] = region.min_m[axis] - margin_m;
    explore.region_max_m[i] = region.max_m[axis] + margin_m;
  }
}

/// The thesis' method as printed (docs/missions.md): its viewpoints, utility, roadmap, when it plans anew, and depth
/// images once a second.
std::vector<std::string> settings_of(const std::string& preset) {
  if (preset.empty() || preset == "default") return {};
  if (preset != "thesis") throw InputError("there is no preset " + preset + ": thesis, or default");
  return {"mission.explore.viewpoints.preset=thesis",         "mission.explore.tour.objective=utility",
          "mission.explore.low_level.leg.planner=lazy_prm",   "mission.explore.low_level.judge_while_driving=false",
          "mission.explore.low_level.bypass_obstacles=false", "depth.rate_hz=1"};
}

/// The centre plans for robots as mission_process would for its own.
void set_centre(MissionSpec& spec, const RobotConfig& robot) {
  const planning::ExplorerParams& explore = spec.mission.explore;
  planning::CentreParams& centre = spec.centre.centre;
  spec.patch.rig = spec.centre.rig = robot.rig;
  spec.patch.tsdf = centre.tsdf = explore.tsdf;
  centre.viewpoints = explore.viewpoints;
  centre.grid = explore.grid;
  centre.footprint = explore.footprint;
  centre.costs = explore.costs;
  centre.footprint_margin_m = explore.footprint_margin_m;
  centre.start_clearance_m = explore.start_clearance_m;
  centre.nominal_speed_mps = explore.nominal_speed_mps;
  centre.nominal_turn_rate_radps = explore.nominal_turn_rate_radps;
  centre.visit_s = explore.visit_s;
}

}  // namespace

MissionSpec load_mission(const std::filesystem::path& file, const MissionOverrides& overrides) {
  MissionSpec spec;
  spec.sim.world = spec.sim.robot = spec.base.robot = spec.tracker.robot = kFilledIn;
  spec.depth.rig = spec.odometry.rig = spec.tags.rig = spec.mapping.rig = kFilledIn;
  spec.patch.rig = spec.centre.rig = kFilledIn;
  spec.base.port = "bus";
  spec.mapping.pose_source = "pair_pose";
  spec.depth.publish_disparity = false;
  std::vector<std::string> settings = settings_of(overrides.preset);
  settings.insert(settings.end(), overrides.settings.begin(), overrides.settings.end());
  config::read(spec, {.file = file, .settings = settings});
  if (!overrides.world.empty()) spec.world = overrides.world;
  if (overrides.seed) spec.seed = *overrides.seed;
  if (!overrides.sensing.empty()) spec.sensing = overrides.sensing;
  if (overrides.robots) spec.robots = *overrides.robots;
  if (!overrides.kill.empty()) spec.kill = overrides.kill;
  if (!overrides.join.empty()) spec.join = overrides.join;
  config::check(spec, file.string());

  // Live, the processes' configurations lie in another folder.
  spec.world = std::filesystem::absolute(spec.world);
  spec.robot = std::filesystem::absolute(spec.robot);
  auto robot = config::load<RobotConfig>(spec.robot);
  robot.rig = std::filesystem::absolute(robot.rig);
  const sim::World world = sim::load_world(spec.world);
  (void)sim::start_of(world, spec.start);  // live it would be the simulator that finds it out
  spec.sim.world = spec.world;
  spec.sim.robot = spec.base.robot = spec.tracker.robot = spec.robot;
  spec.sim.start = spec.start;
  spec.sim.seed = spec.seed;
  spec.sim.sensing = spec.sensing;
  spec.odometry.odometry.seed = spec.seed;
  const auto rig = overrides.rig.empty() ? robot.rig : std::filesystem::absolute(overrides.rig);
  spec.depth.rig = spec.odometry.rig = spec.tags.rig = spec.mapping.rig = rig;
  spec.pose.fusion.wheels.track_m = robot.base.geometry.track_m;
  spec.mission.rig = rig;
  spec.mission.explore.tsdf = spec.mapping.tsdf;
  spec.mission.explore.footprint = {robot.semi_axis_long_m, robot.semi_axis_short_m};
  spec.mission.explore.nominal_speed_mps = robot.limits.max_speed_mps;
  spec.mission.stop_guard.deceleration_mps2 = robot.limits.max_acceleration_mps2;
  spec.mission.explore.low_level.deceleration_mps2 = kShareOfBrakes * robot.limits.max_acceleration_mps2;
  set_centre(spec, robot);
  if (spec.use_region) {
    set_region(world.region, spec.mission.explore);
    set_region(world.region, spec.centre.centre);
  }
  if (world.tag_cube) spec.tags.cube = to_config(*world.tag_cube);
  return spec;
}

std::vector<std::string> robot_names(const MissionSpec& spec) {
  std::vector<std::string> names;
  for (int i = 0; i < spec.robots; ++i) names.push_back("R" + std::to_string(i + 1));
  return names;
}

MissionSpec spec_of_robot(const MissionSpec& team, int robot) {
  const std::vector<std::string> names = robot_names(team);
  MissionSpec spec = team;
  const std::string& name = names[static_cast<std::size_t>(robot)];
  spec.start = spec.sim.start = team.start + robot;
  spec.seed = spec.sim.seed = spec.odometry.odometry.seed = team.seed + kSeedStep * robot;
  for (const std::string& other : names) {
    if (other != name) spec.sim.teammates += (spec.sim.teammates.empty() ? "" : ",") + other;
  }
  spec.mission.explore.led = true;
  spec.mission.team.robot = spec.patch.source = name;
  spec.mission.team.traffic.deceleration_mps2 = team.mission.stop_guard.deceleration_mps2;
  return spec;
}

namespace {

std::vector<TeamEvent> events_of(const std::string& text, const char* option, const MissionSpec& spec) {
  const std::vector<std::string> names = robot_names(spec);
  std::vector<TeamEvent> events;
  for (const std::string& item : split(text, ',')) {
    const std::size_t at = item.find('@');
    TeamEvent event{item.substr(0, at), 0};
    const bool known = event.who == kCentre || std::find(names.begin(), names.end(), event.who) != names.end();
    std::istringstream number(at == std::string::npos ? "" : item.substr(at + 1));
    if (!known || !(number >> event.at_s) || !number.eof() || !(event.at_s >= 0)) {
      throw InputError(std::string(option) + ": \"" + item + "\" must be ROBOT@SECONDS or centre@SECONDS, e.g. R2@40");
    }
    events.push_back(event);
  }
  return events;
}

}  // namespace

std::vector<TeamEvent> deaths(const MissionSpec& spec) {
  return events_of(spec.kill, "kill", spec);
}

std::vector<TeamEvent> joins(const MissionSpec& spec) {
  std::vector<TeamEvent> joins = events_of(spec.join, "join", spec);
  const std::vector<TeamEvent> killed = deaths(spec);
  for (const TeamEvent& join : joins) {
    const bool was_killed = std::any_of(killed.begin(), killed.end(), [&](const TeamEvent& death) {
      return death.who == join.who && death.at_s < join.at_s;
    });
    if (join.who == kCentre && !was_killed) throw InputError("join: the centre starts again after it was killed");
  }
  return joins;
}

}  // namespace arpent::tools
