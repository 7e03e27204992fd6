// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/team_live_result.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "mapping/surface/mesh_extraction.h"
#include "mapping/tsdf/map_file.h"
#include "planning/team/wire.h"
#include "tools/mission/live_bus.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;

constexpr double kTruthHz = 50;
/// A simulator that has less than this share of its cycles is late.
constexpr double kInTime = 0.95;

constexpr std::array<std::pair<const char*, const char*>, 4> kSentAndReceived{
    {{channels::kMapPatch, channels::kTeamPatch},
     {channels::kRobotState, channels::kTeamState},
     {channels::kTour, channels::kTeamTour},
     {channels::kTourReport, channels::kTeamReport}}};

}  // namespace

MissionResult result_of_robot(const fs::path& raw_log, const MissionSpec& robot) {
  MissionResult result;
  result.log = raw_log.parent_path() / "mission.lcmlog";
  finish_log(raw_log, result, robot);
  return result;
}

planning::CentreStatus status_of_centre(const fs::path& raw_log) {
  planning::CentreStatus status;
  std::set<std::int64_t> plans;
  std::set<std::pair<std::string, std::int64_t>> patches;
  LogReader reader(raw_log);
  LogWriter log(raw_log.parent_path() / "mission.lcmlog");
  while (const auto event = reader.next()) {
    log.write(event->time, event->channel, event->data);
    if (event->channel == channels::kTour) {
      decode<tour_t>(event->data, [&](const tour_t& m) {
        plans.insert(m.utime);
        status.done = m.done != 0;
      });
    } else if (event->channel == channels::kTeamPatch) {
      decode<map_patch_t>(event->data, [&](const map_patch_t& m) { patches.insert({m.source, m.sample}); });
    }
  }
  log.close();
  fs::remove(raw_log);
  status.plans = static_cast<int>(plans.size());
  status.patches = static_cast<std::int64_t>(patches.size());
  return status;
}

TriangleMesh take_mesh(const fs::path& map_file) {
  if (!fs::exists(map_file)) return {};
  TriangleMesh mesh = mapping::extract_mesh(mapping::load_map(map_file).map);
  fs::remove(map_file);
  return mesh;
}

std::map<std::string, std::int64_t> radio_bytes(const std::map<std::string, ProcessFigures>& processes,
                                                std::int64_t on_air) {
  std::map<std::string, std::int64_t> bytes;
  std::int64_t payload = 0;
  for (const auto& [process, figures] : processes) {
    for (const auto& [sent, received] : kSentAndReceived) {
      const auto counter = figures.counters.find(std::string(sent) + ".radio_bytes_sent");
      if (counter == figures.counters.end()) continue;
      bytes[received] += counter->second;
      payload += counter->second;
    }
  }
  bytes["overhead"] = std::max<std::int64_t>(0, on_air - payload);
  return bytes;
}

void warn_if_late(const TeamResult& result) {
  for (std::size_t i = 0; i < result.names.size(); ++i) {
    const evaluation::Trajectory& truth = result.robots[i].truth;
    if (truth.size() < 2) continue;
    const double cycles = kTruthHz * to_seconds(truth.back().stamp - truth.front().stamp);
    const double share = static_cast<double>(truth.size() - 1) / cycles;
    if (share > kInTime) continue;
    std::fprintf(stderr,
                 "mission: this machine is too slow: the world of %s had %.0f %% of real time. Fewer robots, or "
                 "--sensing depth, or lockstep\n",
                 result.names[i].c_str(), 100 * share);
  }
}

}  // namespace arpent::tools
