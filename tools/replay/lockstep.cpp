// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <time.h>

#include <arpent/map_status_t.hpp>
#include <arpent/odometry_t.hpp>
#include <chrono>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/crc32c.h"
#include "common/log/event_log.h"
#include "common/memory.h"
#include "mapping/surface/mesh_extraction.h"
#include "tools/progress.h"
#include "tools/replay/collect.h"
#include "tools/replay/replay.h"

namespace arpent::tools {
namespace {

double process_cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

void Collector::take(Time time, const std::string& channel, BytesView bytes) {
  if (log_) log_->write(time, channel, bytes);
  if (channel == channels::kStereoImages) {
    ++result_.pairs;
    return;
  }
  const std::int64_t utime = to_utime(time);
  result_.log_crc = crc32c_of(std::span<const std::int64_t>(&utime, 1), result_.log_crc);
  result_.log_crc = crc32c_of(bytes, result_.log_crc);
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
  return since >= Duration(0) && since < from_seconds(options_.duration_s) && index % options_.step == 0;
}

ReplayResult run_lockstep(const ReplayInput& input, const ReplayOptions& options) {
  keep_freed_memory();
  const double cpu_start = process_cpu_s();
  const auto wall_start = std::chrono::steady_clock::now();
  ReplayResult result;
  std::unique_ptr<LogWriter> log;
  if (!options.out_log.empty()) log = std::make_unique<LogWriter>(options.out_log);
  Collector collector(result, log.get());
  LockstepStack stack(input.pairs.front(), options.threads);
  LockstepExecutor& executor = stack.executor();
  executor.set_tap(
      [&](Time time, const std::string& channel, BytesView bytes) { collector.take(time, channel, bytes); });
  const bool depth = options.processes.contains("depth"), odometry = options.processes.contains("odometry");
  if (depth) stack.add<DepthProcess>(input.config.depth);
  if (odometry) stack.add<OdometryProcess>(input.config.odometry);
  const MappingProcess* mapping =
      options.processes.contains("mapping") ? &stack.add<MappingProcess>(input.config.mapping) : nullptr;
  LogReader reader(input.log);
  const Window window(input.pairs.front(), options);
  std::size_t seen = 0;
  while (const auto event = reader.next()) {
    // Only inputs are played: what the processes publish themselves comes from them. Outputs of processes that do not
    // run are inputs.
    const bool pair = event->channel == channels::kStereoImages;
    const bool other =
        (event->channel == channels::kDepth && !depth) || (event->channel == channels::kOdometry && !odometry);
    if (!pair && !other) continue;
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
