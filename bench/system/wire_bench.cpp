// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `wire`: stereo pairs over the live bus with all losses accounted for, replay identity, logs under damage, and
// the whole chain on the real clip (or, without ARPENT_DATA, on the rendered one).
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <arpent/stereo_images_t.hpp>
#include <chrono>
#include <filesystem>
#include <opencv2/core.hpp>
#include <thread>

#include "bench/harness.h"
#include "common/bus/lcm_bus.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/log/damage_probe.h"
#include "common/log/event_log.h"
#include "common/net/private_network.h"
#include "perception/stereo/wire.h"
#include "tools/import/import.h"
#include "tools/replay/summary.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;
using Steady = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr int kRateHz = 30;
constexpr int kSeconds = 20;
constexpr int kSubscribers = 3;

struct Tally {
  std::int64_t handled = 0;
  std::int64_t lost = 0;  ///< as counted in health
  std::int64_t bad = 0;
};

/// A subscriber in a process of its own; it ends 1.5 s after the last pair and sends its tally through the pipe.
void run_subscriber(const std::string& url, int pipe_fd) {
  LcmBus bus(url);
  auto last = Steady::now() + 5s;
  subscribe<stereo_images_t>(bus, channels::kStereoImages, {.queue_capacity = 4}, [&](const stereo_images_t& message) {
    if (!stereo::from_wire(message)) bus.health().count(channels::kStereoImages, "invalid");
    last = Steady::now();
  });
  bus.start();
  while (Steady::now() < last + 1500ms) bus.run_for(20ms);
  const auto count = [&](const char* what) { return bus.health().counter(channels::kStereoImages, what); };
  const Tally tally{count("handled"), count("lost"), count("undecodable") + count("invalid")};
  [[maybe_unused]] const auto written = write(pipe_fd, &tally, sizeof tally);
}

void measure_bus(bench::Report& report) {
  (void)enter_private_network();
  const std::string url = fmt::format("udpm://239.255.76.67:{}?ttl=0&recv_buf_size=4194304", private_port());
  std::vector<int> pipes;
  for (int i = 0; i < kSubscribers; ++i) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    if (fork() == 0) {
      run_subscriber(url, ends[1]);
      _exit(0);
    }
    close(ends[1]);
    pipes.push_back(ends[0]);
  }
  std::this_thread::sleep_for(1s);
  LcmBus bus(url);
  cv::Mat1b image(512, 640);
  cv::RNG(1).fill(image, cv::RNG::UNIFORM, 0, 256);
  stereo_images_t message = stereo::to_wire({Time(), 0, image, image}, false);
  const int sent = kRateHz * kSeconds;
  const auto start = Steady::now();
  for (int i = 0; i < sent; ++i) {
    message.sequence = i;
    publish(bus, channels::kStereoImages, message);
    std::this_thread::sleep_until(start + (i + 1) * 1000000us / kRateHz);
  }
  std::int64_t unaccounted = 0, lost = 0;
  for (const int fd : pipes) {
    Tally tally;
    if (read(fd, &tally, sizeof tally) != sizeof tally) unaccounted += sent;
    close(fd);
    unaccounted += std::abs(sent - tally.handled - tally.lost - tally.bad);
    lost += sent - tally.handled;
  }
  while (wait(nullptr) > 0) {
  }
  report.add("bus.pairs_unaccounted", static_cast<double>(unaccounted), "1",
             fmt::format("bar 0; {} pairs to {} subscribers", sent, kSubscribers));
  report.add("bus.pairs_lost_percent", 100.0 * static_cast<double>(lost) / (sent * kSubscribers), "%", "bar <= 0.1");
}

void measure_log(bench::Report& report, const fs::path& scratch) {
  const fs::path log = scratch / "small.lcmlog";
  {
    LogWriter writer(log);
    for (int i = 0; i < 20; ++i)
      writer.write(from_utime(i), "CHANNEL", std::vector<std::uint8_t>(40, static_cast<std::uint8_t>(i)));
    writer.close();
  }
  const DamageProbe probe = probe_damage(log, scratch / "damaged.lcmlog");
  report.add("log.events_lost_max", static_cast<double>(probe.most_lost), "1",
             fmt::format("bar <= 2; {} damaged copies", probe.cases));
}

double p95(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[static_cast<std::size_t>(0.95 * static_cast<double>(values.size() - 1))];
}

/// A process that takes longer than it declares makes simulated missions too fast: worth a line each.
void check_latencies(bench::Report& report, const tools::ReplayInput& input, const tools::ReplayResult& result) {
  const auto check = [&](const char* process, const char* channel, int declared_us) {
    const auto& timings = result.processes.at(process).handler_ms;
    const auto found = timings.find(channel);
    if (found != timings.end())
      report.add(fmt::format("latency.{}_p95_over_declared", process), 1e3 * p95(found->second) / declared_us, "1",
                 "bar <= 1");
  };
  check(DepthProcess::kName, channels::kStereoImages, input.config.depth.latency_us);
  check(OdometryProcess::kName, channels::kStereoImages, input.config.odometry.latency_us);
  check(MappingProcess::kName, channels::kDepth, input.config.mapping.latency_us);
}

void measure_chain(bench::Report& report, const fs::path& scratch, const fs::path& bin) {
  const fs::path log = scratch / "chain.lcmlog";
  if (bench::data_dir().empty()) {
    tools::import_rendered(6.0, log);
  } else {
    tools::import_kitti(fs::path(bench::data_dir()) / "vo" / "kitti06_0000-0039", log);
  }
  const tools::ReplayInput input = tools::open_log(log, scratch, "", {});
  tools::ReplayOptions options;
  options.threads = 1;
  const tools::ReplayResult first = tools::run_lockstep(input, options);
  options.threads = 2;
  const tools::ReplayResult second = tools::run_lockstep(input, options);
  const tools::ReplayResult live = tools::run_live(input, options, bin, scratch / "live");
  const bool same = first.log_crc == second.log_crc && tools::compare(first, second).identical();
  const bool live_same = tools::compare(first, live).identical();
  report.add("replay.identical_lockstep", same ? 1 : 0, "1", "two lockstep runs, 1 and 2 threads");
  report.add("replay.identical_live", live_same ? 1 : 0, "1", "live against lockstep: depth, map, mesh");
  report.add("replay.identical", same && live_same ? 1 : 0, "1", "bar 1");
  report.add("pipeline.realtime_factor", to_seconds(input.pairs.back() - input.pairs.front()) / first.cpu_s, "1",
             "recorded time over CPU time, depth at 5 Hz");
  check_latencies(report, input, first);
  if (const auto bad2 = tools::measure_reprojection(input, first))
    report.add("pipeline.reprojection_bad2_percent", *bad2, "%", "reported");
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  using namespace arpent;
  return bench::run(argc, argv, "The wire: bus, replay identity, logs, the whole chain", [](bench::Report& report) {
    cv::setNumThreads(1);
    const fs::path scratch = fs::temp_directory_path() / ("arpent_wire_" + std::to_string(getpid()));
    fs::create_directories(scratch);
    measure_bus(report);
    measure_log(report, scratch);
    measure_chain(report, scratch, fs::canonical("/proc/self/exe").parent_path());
    fs::remove_all(scratch);
  });
}
