// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <arpent/health_t.hpp>
#include <chrono>
#include <thread>

#include "common/atomic_file.h"
#include "common/bus/lcm_bus.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/config.h"
#include "common/error.h"
#include "common/log/event_log.h"
#include "common/net/private_network.h"
#include "tools/launch/launcher.h"
#include "tools/progress.h"
#include "tools/replay/collect.h"
#include "tools/replay/replay.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using Steady = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// The part of the log that is played, without what the processes publish themselves.
std::int64_t write_input_log(const ReplayInput& input, const ReplayOptions& options, const fs::path& file) {
  LogReader reader(input.log);
  LogWriter writer(file);
  const Window window(input.pairs.front(), options);
  std::int64_t seen = 0;
  std::int64_t pairs = 0;
  while (const auto event = reader.next()) {
    const bool pair = event->channel == channels::kStereoImages;
    if (!pair && event->channel != channels::kWheelState && event->channel != channels::kImu) continue;
    if (!window.wants(event->time, pair ? seen++ : 0)) continue;
    writer.write(event->time, event->channel, event->data);
    pairs += pair ? 1 : 0;
  }
  writer.close();
  return pairs;
}

/// Hears which processes are alive.
class Roll {
 public:
  explicit Roll(const std::string& url) : bus_(url) {
    subscribe<health_t>(bus_, channels::kHealth, {.queue_capacity = 100}, [this](const health_t& health) {
      ProcessFigures& figures = figures_[health.process];
      for (const auto& counter : health.counters) figures.counters[counter.name] = counter.value;
      if (!health.message.empty()) figures.messages.emplace_back(health.message, 1);
    });
    bus_.start();
  }
  void listen(std::chrono::milliseconds time) {
    const auto until = Steady::now() + time;
    while (Steady::now() < until) bus_.run_for(20ms);
  }
  [[nodiscard]] bool all_present(std::size_t count) const { return figures_.size() >= count; }
  [[nodiscard]] std::int64_t count(const std::string& process, const std::string& counter) const {
    const auto figures = figures_.find(process);
    if (figures == figures_.end()) return 0;
    const auto found = figures->second.counters.find(counter);
    return found == figures->second.counters.end() ? 0 : found->second;
  }
  [[nodiscard]] const std::map<std::string, ProcessFigures>& figures() const { return figures_; }

 private:
  LcmBus bus_;
  std::map<std::string, ProcessFigures> figures_;
};

/// Waits until the pairs have been handled and nothing more happens for two seconds.
void wait_until_quiet(Launcher& launcher, Roll& roll, std::int64_t pairs) {
  std::int64_t last = -1;
  auto changed = Steady::now();
  const auto limit = Steady::now() + 10min;
  while (Steady::now() < limit) {
    launcher.poll(10);
    roll.listen(100ms);
    const std::int64_t handled = roll.count(OdometryProcess::kName, "STEREO_IMAGES.handled");
    const std::int64_t activity = handled + roll.count(MappingProcess::kName, "DEPTH.handled") +
                                  roll.count(DepthProcess::kName, "STEREO_IMAGES.handled");
    show_progress("live", static_cast<std::size_t>(std::min(handled, pairs)), static_cast<std::size_t>(pairs));
    if (activity != last) changed = Steady::now();
    last = activity;
    if (!launcher.running("logplayer") && Steady::now() - changed > 2500ms) return;
  }
  throw InputError("the live replay does not come to an end: see the launcher's log");
}

}  // namespace

ReplayResult run_live(const ReplayInput& input, const ReplayOptions& options, const fs::path& bin_folder,
                      const fs::path& work_folder) {
  const auto wall_start = Steady::now();
  const std::string not_private = enter_private_network();
  const std::string url = fmt::format("udpm://239.255.76.67:{}?ttl=0&recv_buf_size=4194304", private_port());
  fs::create_directories(work_folder);
  ReplayConfig config = input.config;
  config.mapping.mesh_file = fs::absolute(work_folder / "live_mesh.ply");
  const fs::path in_log = work_folder / "live_in.lcmlog";
  const fs::path out_log = options.out_log.empty() ? work_folder / "live_out.lcmlog" : options.out_log;
  std::error_code ignored;
  fs::remove(out_log, ignored);
  fs::remove(config.mapping.mesh_file, ignored);
  const std::int64_t pairs = write_input_log(input, options, in_log);
  atomic_write(work_folder / "depth.yaml", config::to_yaml(config.depth));
  atomic_write(work_folder / "odometry.yaml", config::to_yaml(config.odometry));
  atomic_write(work_folder / "tag.yaml", config::to_yaml(config.tags));
  atomic_write(work_folder / "pose.yaml", config::to_yaml(config.pose));
  atomic_write(work_folder / "mapping.yaml", config::to_yaml(config.mapping));
  const std::set<std::string> running = processes_to_run(input, options);

  Launcher launcher(work_folder / "launch.log");
  Roll roll(url);
  for (const std::string& name : running) {
    launcher.start({name,
                    {(bin_folder / (name + "_process")).string(), "--config", (work_folder / (name + ".yaml")).string(),
                     "--lcm-url", url},
                    true});
  }
  launcher.start({"logger", {"lcm-logger", "--lcm-url=" + url, "-f", out_log.string()}, false});
  for (int i = 0; i < 100 && !roll.all_present(running.size()); ++i) {
    launcher.poll(10);
    roll.listen(100ms);
  }
  if (!roll.all_present(running.size())) {
    throw InputError("not all processes came up; see " + (work_folder / "launch.log").string());
  }
  roll.listen(300ms);
  launcher.start(
      {"logplayer", {"lcm-logplayer", "-s", fmt::format("{}", options.speed), "-l", url, in_log.string()}, false});
  wait_until_quiet(launcher, roll, pairs);
  for (const std::string& name : running) launcher.stop(name, 20000);
  roll.listen(300ms);
  launcher.stop_all(5000);

  ReplayResult result;
  Collector collector(result, nullptr, running);
  LogReader reader(out_log);
  while (const auto event = reader.next()) collector.take(event->time, event->channel, event->data);
  result.processes = roll.figures();
  if (fs::exists(config.mapping.mesh_file)) result.mesh = read_ply(config.mapping.mesh_file);
  result.wall_s = std::chrono::duration<double>(Steady::now() - wall_start).count();
  return result;
}

}  // namespace arpent::tools
