// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/lockstep.h"

#include <arpent/config_t.hpp>
#include <chrono>
#include <fstream>
#include <sstream>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/config/robot.h"
#include "common/cpu_time.h"
#include "common/error.h"
#include "common/memory.h"
#include "mapping/surface/mesh_extraction.h"
#include "tools/mission/disk_reserve.h"
#include "tools/mission/live.h"
#include "tools/progress.h"
#include "tools/replay/replay.h"

namespace arpent::tools {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void show(const MissionResult& result) {
  if (result.reports.empty()) return;
  const planning::MissionReport& report = result.reports.back();
  show_progress(report.activity, static_cast<std::size_t>(report.progress * kProgressSteps), kProgressSteps);
}

}  // namespace

SimProcess& add_robot(LockstepStack& stack, const MissionSpec& robot, const std::string& prefix) {
  SimProcess& sim = stack.add<SimProcess>(robot.sim, prefix);
  stack.add<BaseDriverProcess>(robot.base, prefix);
  if (robot.sensing == "images") {
    stack.add<DepthProcess>(robot.depth, prefix);
    stack.add<OdometryProcess>(robot.odometry, prefix);
    stack.add<TagProcess>(robot.tags, prefix);
  }
  stack.add<PoseProcess>(robot.pose, prefix);
  stack.add<TrackerProcess>(robot.tracker, prefix);
  return sim;
}

/// The parameters of perception and mapping, so that the log replays with nothing else at hand.
void write_configs(LogWriter& log, Time time, const MissionSpec& spec) {
  ReplayConfig replay;
  replay.depth = spec.depth;
  replay.odometry = spec.odometry;
  replay.tags = spec.tags;
  replay.pose = spec.pose;
  replay.mapping = spec.mapping;
  // The log's reader puts the rig where it wants it; nothing is saved elsewhere.
  replay.depth.rig = replay.odometry.rig = replay.tags.rig = replay.mapping.rig = "-";
  replay.mapping.map_file = replay.mapping.mesh_file = "";
  const auto write = [&](const char* name, const std::string& yaml) {
    config_t message{};
    message.utime = to_utime(time);
    message.name = name;
    message.yaml = yaml;
    log.write(time, channels::kConfig, encode(message));
  };
  write("rig", config::to_yaml(load_rig(spec.depth.rig).config));
  write("replay", config::to_yaml(replay));
  write("robot", text_of(spec.robot));
  write("world", text_of(spec.world));
}

namespace {

MissionResult run_lockstep(const MissionSpec& spec, const MissionOptions& options) {
  keep_freed_memory();
  const double cpu_start = process_cpu_s();
  const auto wall_start = std::chrono::steady_clock::now();
  MissionResult result;
  result.log = options.out / "mission.lcmlog";
  DiskReserve reserve(options.out);
  LogWriter log(result.log);
  write_configs(log, kStart, spec);
  MissionCollector collector(result, &log);
  LockstepStack stack(kStart, options.threads);
  stack.executor().set_tap(
      [&](Time time, const std::string& channel, BytesView bytes) { collector.take(time, channel, bytes); });
  const SimProcess& sim = add_robot(stack, spec);
  const MappingProcess& mapping = stack.add<MappingProcess>(spec.mapping);
  stack.add<MissionProcess>(spec.mission);
  stack.executor().inject(kStart + kStartAfter, channels::kMissionCommand,
                          encode(planning::to_wire(kStart, {planning::MissionCommand::kStart, "mission"})));
  while (!result.ended() && !interrupted()) {
    stack.executor().run_until(stack.executor().now() + kStep);
    if (collector.log_was_refused()) reserve.log_was_refused();
    if (options.progress) show(result);
  }
  stack.executor().run_until(stack.executor().now() + kRunOut);
  stack.finish();
  stack.executor().run_until(stack.executor().now() + kStep);
  collector.close();
  result.collisions = sim.collisions();
  result.mesh = mapping::extract_mesh(mapping.map());
  result.processes = stack.figures();
  result.cpu_s = process_cpu_s() - cpu_start;
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start).count();
  return result;
}

}  // namespace

MissionResult run_mission(const MissionSpec& spec, const MissionOptions& options) {
  std::filesystem::create_directories(options.out);
  MissionSpec filled = spec;
  filled.mission.certificate_file = std::filesystem::absolute(options.out / "certificate.json");
  std::filesystem::remove(filled.mission.certificate_file);
  return options.live ? run_live_mission(filled, options) : run_lockstep(filled, options);
}

}  // namespace arpent::tools
