// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/folder.h"

#include <arpent/config_t.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;

using Configs = std::map<std::string, std::string>;

/// What the processes' paths are in a log: they mean nothing there.
constexpr const char* kNoPath = "-";

Configs take_events(const fs::path& log, MissionResult& result) {
  Configs configs;
  MissionCollector collector(result, nullptr);
  LogReader reader(log);
  while (const auto event = reader.next()) {
    if (event->channel != channels::kConfig) {
      collector.take(event->time, event->channel, event->data);
      continue;
    }
    config_t message;
    std::string fault;
    if (decode_guarded(event->data, message, fault)) configs[message.name] = message.yaml;
  }
  return configs;
}

void use_configs(const Configs& configs, const std::string& log, const fs::path& world, MissionSetting& setting) {
  for (const char* name : {"rig", "robot", "replay", "world"}) {
    const bool needed = std::string(name) != "world" || world.empty();
    if (needed && !configs.contains(name)) throw InputError(log + ": brings no " + name + " along (CONFIG)");
  }
  setting.rig = config::load_text<RigConfig>(log + " (rig)", configs.at("rig"));
  setting.robot = config::load_text<RobotConfig>(log + " (robot)", configs.at("robot"));
  ReplayConfig& replay = setting.replay;
  replay.depth.rig = replay.odometry.rig = replay.tags.rig = replay.mapping.rig = kNoPath;
  config::read(replay, {.text = configs.at("replay"), .text_name = log + " (replay)"});
  setting.world = world.empty() ? sim::parse_world(configs.at("world"), log + " (world)") : sim::load_world(world);
}

/// The mission's name is what stands before the dot in mission.json; some figures only it has.
void use_figures(const fs::path& file, MissionFolder& folder) {
  folder.setting.name = "mission";
  std::ifstream in(file);
  if (!in) return;
  const auto rows = nlohmann::json::parse(in, nullptr, false);
  if (!rows.is_array()) throw InputError(file.string() + ": is no list of figures");
  for (const auto& row : rows) {
    const std::string name = row.value("name", "");
    const std::size_t dot = name.rfind('.');
    if (dot == std::string::npos || !row.contains("value") || !row["value"].is_number()) continue;
    folder.setting.name = name.substr(0, dot);
    if (name.substr(dot) == ".collisions") folder.collisions = row["value"].get<double>();
    if (name.substr(dot) == ".realtime_factor") folder.realtime_factor = row["value"].get<double>();
  }
}

}  // namespace

MissionSetting setting_of(const MissionSpec& spec, const MissionResult& result) {
  MissionSetting setting;
  setting.name = spec.name;
  setting.world = sim::load_world(spec.world);
  setting.robot = config::load<RobotConfig>(spec.robot);
  setting.rig = load_rig(spec.depth.rig).config;
  setting.replay.mapping = spec.mapping;
  if (!result.truth.empty()) setting.start = to_pose2(result.truth.front().T_ref_body);
  return setting;
}

MissionFolder read_mission_folder(const fs::path& folder, const fs::path& world) {
  MissionFolder mission;
  const fs::path log = folder / "mission.lcmlog";
  if (!fs::exists(log)) throw InputError(folder.string() + ": has no mission.lcmlog");
  mission.result.log = log;
  use_configs(take_events(log, mission.result), log.string(), world, mission.setting);
  if (mission.result.truth.empty()) throw InputError(log.string() + ": has no " + channels::kTruthPose);
  mission.setting.start = to_pose2(mission.result.truth.front().T_ref_body);
  if (fs::exists(folder / "mesh.ply")) mission.result.mesh = read_ply(folder / "mesh.ply");
  use_figures(folder / "mission.json", mission);
  if (mission.collisions) mission.result.collisions = static_cast<int>(*mission.collisions);
  return mission;
}

evaluation::LegalViews legal_views(const MissionSetting& setting) {
  const auto rig = to_calibration(setting.rig, setting.rig.name);
  const mapping::TsdfParams& tsdf = setting.replay.mapping.tsdf;
  return {setting.world, setting.start,
          evaluation::legal_view_params(setting.robot, rig, std::max(setting.rig.min_range_m, tsdf.min_range_m),
                                        std::min(setting.rig.max_range_m, tsdf.max_range_m))};
}

}  // namespace arpent::tools
