// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <arpent/map_status_t.hpp>
#include <arpent/odometry_t.hpp>
#include <chrono>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/cpu_time.h"
#include "common/crc32c.h"
#include "common/log/event_log.h"
#include "common/memory.h"
#include "mapping/surface/mesh_extraction.h"
#include "tools/progress.h"
#include "tools/replay/collect.h"
#include "tools/replay/compact.h"
#include "tools/replay/replay.h"

namespace arpent::tools {
namespace {

std::uint32_t crc_in_log(const std::string& channel, BytesView bytes) {
  const Bytes compact = compact_for_log(channel, bytes);
  return crc32c_of(BytesView(compact));
}

const std::vector<std::string> kAllProcesses{"depth", "odometry", "tag", "pose", "mapping"};

/// Only inputs are played: what the processes publish themselves comes from them. Outputs of processes that do not run
/// are inputs.
std::set<std::string> channels_to_play(const std::set<std::string>& running) {
  std::set<std::string> play{channels::kStereoImages, channels::kWheelState, channels::kImu};
  for (const std::string& process : kAllProcesses) {
    if (running.contains(process)) continue;
    for (const std::string& channel : outputs_of(process)) play.insert(channel);
  }
  return play;
}

/// The mapping process, or nullptr if it does not run.
const MappingProcess* add_processes(LockstepStack& stack, const ReplayConfig& config,
                                    const std::set<std::string>& running) {
  if (running.contains("depth")) stack.add<DepthProcess>(config.depth);
  if (running.contains("odometry")) stack.add<OdometryProcess>(config.odometry);
  if (running.contains("tag")) stack.add<TagProcess>(config.tags);
  if (running.contains("pose")) stack.add<PoseProcess>(config.pose);
  return running.contains("mapping") ? &stack.add<MappingProcess>(config.mapping) : nullptr;
}

}  // namespace

std::vector<std::string> outputs_of(const std::string& process) {
  if (process == "depth") return {channels::kDepth, channels::kDisparity, channels::kDisparityFilled};
  if (process == "odometry") return {channels::kOdometry};
  if (process == "tag") return {channels::kTagObservation, channels::kFrameAlignment};
  if (process == "pose") return {channels::kPose, channels::kPairPose};
  if (process == "mapping") return {channels::kMapStatus};
  return {};
}

std::set<std::string> processes_to_run(const ReplayInput& input, const ReplayOptions& options) {
  if (!options.processes.empty()) return options.processes;
  std::set<std::string> all(kAllProcesses.begin(), kAllProcesses.end());
  if (!input.drive) {
    all.erase("tag");
    all.erase("pose");
  }
  return all;
}

LogComparison compare_with_log(const ReplayInput& input, const ReplayResult& result) {
  std::map<std::string, std::vector<std::uint32_t>> logged;
  LogReader reader(input.log);
  Time end = input.begin;
  while (const auto event = reader.next()) {
    end = std::max(end, event->time);
    if (!result.outputs.contains(event->channel)) continue;
    logged[event->channel].push_back(crc_in_log(event->channel, event->data));
  }
  LogComparison comparison;
  for (const auto& [channel, crcs] : logged) {
    std::vector<std::uint32_t> ours;
    for (const auto& [time, crc] : result.outputs.at(channel)) {
      if (time <= end) ours.push_back(crc);
    }
    comparison.compared += static_cast<std::int64_t>(crcs.size());
    std::int64_t different = 0;
    for (std::size_t i = 0; i < crcs.size(); ++i) different += i >= ours.size() || crcs[i] != ours[i] ? 1 : 0;
    comparison.different += different;
    comparison.further += ours.size() > crcs.size() ? static_cast<std::int64_t>(ours.size() - crcs.size()) : 0;
    if (different > 0) comparison.different_by_channel[channel] = different;
  }
  return comparison;
}

void Collector::take(Time time, const std::string& channel, BytesView bytes) {
  if (log_) log_->write(time, channel, bytes);
  if (channel == channels::kStereoImages) {
    ++result_.pairs;
    return;
  }
  const std::int64_t utime = to_utime(time);
  result_.log_crc = crc32c_of(std::span<const std::int64_t>(&utime, 1), result_.log_crc);
  result_.log_crc = crc32c_of(bytes, result_.log_crc);
  if (replayed_.contains(channel)) result_.outputs[channel].push_back({time, crc_in_log(channel, bytes)});
  std::string fault;
  if (channel == channels::kOdometry) {
    odometry_t message;
    if (!decode_guarded(bytes, message, fault)) return;
    if (const auto odometry = odometry::from_wire(message)) result_.odometry.push_back(*odometry);
  } else if (channel == channels::kMapStatus) {
    map_status_t message;
    if (!decode_guarded(bytes, message, fault)) return;
    result_.map_digests[message.utime] = static_cast<std::uint32_t>(message.digest_crc32c);
    if (const auto status = mapping::from_wire(message)) result_.map = *status;
  } else if (channel == channels::kDepth && bytes.size() > 16) {
    std::int64_t stamp = 0;  // utime is the first field behind the fingerprint
    for (std::size_t i = 8; i < 16; ++i) stamp = stamp << 8 | bytes[i];
    result_.depth_crc[stamp] = crc32c_of(bytes);
  }
}

bool Window::wants(Time time, std::int64_t index) const {
  const Duration since = time - begin_ - from_seconds(options_.start_s);
  return (since >= Duration(0) || options_.start_s == 0) && since < from_seconds(options_.duration_s) &&
         index % options_.step == 0;
}

ReplayResult run_lockstep(const ReplayInput& input, const ReplayOptions& options) {
  keep_freed_memory();
  const double cpu_start = process_cpu_s();
  const auto wall_start = std::chrono::steady_clock::now();
  ReplayResult result;
  std::unique_ptr<LogWriter> log;
  if (!options.out_log.empty()) log = std::make_unique<LogWriter>(options.out_log);
  const std::set<std::string> running = processes_to_run(input, options);
  Collector collector(result, log.get(), running);
  LockstepStack stack(input.begin, options.threads);
  LockstepExecutor& executor = stack.executor();
  executor.set_tap(
      [&](Time time, const std::string& channel, BytesView bytes) { collector.take(time, channel, bytes); });
  const MappingProcess* mapping = add_processes(stack, input.config, running);
  const std::set<std::string> inputs = channels_to_play(running);
  LogReader reader(input.log);
  const Window window(input.pairs.front(), options);
  std::size_t seen = 0;
  while (const auto event = reader.next()) {
    if (!inputs.contains(event->channel)) continue;
    const bool pair = event->channel == channels::kStereoImages;
    if (!window.wants(event->time, pair ? static_cast<std::int64_t>(seen++) : 0)) continue;
    executor.run_until(std::max(executor.now(), event->time - Duration(1)));
    executor.inject(event->time, event->channel, event->data);
    show_progress("replay", seen, input.pairs.size());
  }
  executor.run_until_idle();
  stack.finish();
  if (mapping != nullptr) result.mesh = mapping::extract_mesh(mapping->map());
  if (log) log->close();
  result.processes = stack.figures();
  result.cpu_s = process_cpu_s() - cpu_start;
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start).count();
  return result;
}

ReplayDifference compare(const ReplayResult& a, const ReplayResult& b) {
  const auto count_different = [](const auto& x, const auto& y) {
    std::int64_t different = 0;
    for (const auto& [utime, crc] : x) {
      const auto other = y.find(utime);
      different += other == y.end() || other->second != crc ? 1 : 0;
    }
    for (const auto& entry : y) different += x.contains(entry.first) ? 0 : 1;
    return different;
  };
  ReplayDifference difference;
  difference.depth_different = count_different(a.depth_crc, b.depth_crc);
  difference.map_different = count_different(a.map_digests, b.map_digests);
  difference.mesh_equal = a.mesh.vertices_m == b.mesh.vertices_m && a.mesh.triangles == b.mesh.triangles;
  return difference;
}

}  // namespace arpent::tools
