// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `link`: four robots' team_link_processes, security on, each in a network namespace of its own, over a hub with
// 20 ms one way and 50 Mbit/s a station: patches of 10 kB, one a second and robot, beside poses at 20 Hz, from LCM bus
// to LCM bus. In real time: about five minutes.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "bench/harness.h"
#include "bench/link/traffic_log.h"
#include "common/channels.h"
#include "common/error.h"
#include "tools/team/keys.h"
#include "tools/team/radio_lab.h"

namespace arpent::bench {
namespace {

namespace fs = std::filesystem;
using Steady = std::chrono::steady_clock;

constexpr int kRobots = 4;
constexpr std::size_t kPatchBytes = 10000;
constexpr std::size_t kPoseBytes = 200;
constexpr double kPatchPeriodS = 1.0;
constexpr double kPosePeriodS = 0.05;
constexpr double kDrainS = 12;

double now_s() {
  return std::chrono::duration<double>(Steady::now().time_since_epoch()).count();
}

/// Four robots on the air.
class Team {
 public:
  Team(const fs::path& scratch, double rate_mbps, std::size_t patch_bytes)
      : patch_bytes_(patch_bytes),
        lab_(stations(scratch), {.loss = 0, .delay_s = 0.02, .rate_mbps = rate_mbps}, ARPENT_BIN_DIR, scratch,
             [this](int station, LcmBus& bus) { listen(station, bus); }) {
    for (int i = 0; i < kRobots; ++i) lab_.start_link(i);
  }

  /// Plays the robots for `duration_s`, with or without patches.
  void play(double duration_s, bool with_patches) {
    const double end_s = now_s() + duration_s;
    double pose_s = now_s(), patch_s = now_s();
    while (now_s() < end_s) {
      for (int i = 0; now_s() >= pose_s && i < kRobots; ++i) {
        lab_.bus(i).publish_bytes(channels::kRobotState, poses.send(i, now_s(), kPoseBytes));
      }
      if (now_s() >= pose_s) pose_s += kPosePeriodS;
      if (with_patches && now_s() >= patch_s) {
        for (int i = 0; i < kRobots; ++i) {
          lab_.bus(i).publish_bytes(channels::kMapPatch, patches.send(i, now_s(), patch_bytes_));
        }
        patch_s += kPatchPeriodS;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  /// Until everybody hears everybody.
  void meet() {
    constexpr double kPatienceS = 30;
    const double start_s = now_s();
    for (double round_s = start_s; !poses.all_pairs(round_s);) {
      if (now_s() > start_s + kPatienceS) throw InputError("the robots do not hear each other");
      round_s = now_s();
      play(0.5, false);
    }
  }

  /// The first robot's link is killed and started again: until poses go from and to everybody [s].
  double rejoin_s() {
    constexpr double kPatienceS = 60;
    lab_.kill_link(0);
    play(0.5, false);
    const double start_s = now_s();
    lab_.start_link(0);
    while (now_s() < start_s + kPatienceS && poses.recovery_s(start_s, 0) > kPatienceS) play(0.1, false);
    return std::min(poses.recovery_s(start_s, 0), kPatienceS);
  }

  [[nodiscard]] TapHub& air() { return lab_.air(); }

  TrafficLog poses{kRobots};
  TrafficLog patches{kRobots};

 private:
  static std::vector<tools::LabStation> stations(const fs::path& scratch) {
    std::vector<tools::LabStation> stations;
    for (int i = 1; i <= kRobots; ++i) {
      const std::string name = fmt::format("R{}", i);
      stations.push_back({.name = name, .keys = scratch / "keys" / name});
    }
    return stations;
  }

  void listen(int station, LcmBus& bus) {
    bus.subscribe_bytes(channels::kTeamState, {.queue_capacity = 100},
                        [this, station](BytesView bytes) { poses.receive(station, now_s(), bytes); });
    bus.subscribe_bytes(channels::kTeamPatch, {.queue_capacity = 1000},
                        [this, station](BytesView bytes) { patches.receive(station, now_s(), bytes); });
  }

  std::size_t patch_bytes_;
  tools::RadioLab lab_;
};

/// A minute of patches and poses at one loss.
void measure_loss(Report& report, Team& team, int loss_percent) {
  constexpr double kSendS = 60;
  team.air().set_loss(0.01 * loss_percent);
  const TapHub::Traffic before = team.air().traffic();
  const double start_s = now_s();
  team.play(kSendS, true);
  const double end_s = now_s();
  team.play(kDrainS, false);
  const double on_air = static_cast<double>(team.air().traffic().bytes - before.bytes);
  const double payload = (kSendS / kPatchPeriodS) * kRobots * kPatchBytes;
  const std::string suffix = fmt::format("_loss{}", loss_percent);
  report.add("link.delivered_2s_percent" + suffix, team.patches.delivered_percent(2.0, start_s, end_s), "%", "bar 100");
  report.add("link.delivered_percent" + suffix, team.patches.delivered_percent(kDrainS, start_s, end_s), "%");
  report.add("link.overhead" + suffix, on_air / (payload * (kRobots - 1)), "1",
             loss_percent == 20 ? "bar <= 1.6; all bytes, poses too, over patch bytes x 3" : "the same");
  report.add("link.control_age_p99_ms" + suffix, 1e3 * team.poses.age_s(0.99, start_s, end_s), "ms",
             loss_percent == 20 ? "bar <= 250" : "");
}

/// One robot is cut off for 10 s, at 1 % loss.
void measure_cut(Report& report, Team& team) {
  constexpr double kCutS = 10;
  team.air().set_loss(0.01);
  team.play(5, true);
  const double cut_s = now_s();
  team.air().cut(0, true);
  team.play(kCutS, true);
  team.air().cut(0, false);
  const double heal_s = now_s();
  team.play(5, true);
  team.play(kDrainS, false);
  report.add("link.recovery_s", team.poses.recovery_s(heal_s, 0), "s", "bar <= 2; fresh poses, slowest pair");
  report.add("link.recovered_percent", team.patches.delivered_percent(1e6, cut_s, heal_s, 0), "%",
             "bar 100; patches of the cut, from and to the robot");
}

/// A robot's link is killed and started again.
void measure_rejoin(Report& report, Team& team, int loss_percent, int times) {
  team.air().set_loss(0.01 * loss_percent);
  std::vector<double> rejoin_s;
  for (int i = 0; i < times; ++i) rejoin_s.push_back(team.rejoin_s());
  const std::string name = fmt::format("link.rejoin_s_loss{}", loss_percent);
  report.add(name, median(rejoin_s), "s", fmt::format("median of {} restarts, slowest pair", times));
  report.add(name + "_max", *std::max_element(rejoin_s.begin(), rejoin_s.end()), "s", "60: not within a minute");
}

/// Long patches on a narrow link: what control waits for there is the queue, so it shows the pace.
void measure_bulk(Report& report, Team& team) {
  constexpr double kSendS = 20;
  team.air().set_loss(0.01);
  const double start_s = now_s();
  team.play(kSendS, true);
  const double end_s = now_s();
  team.play(kDrainS, false);
  report.add("link.control_age_p99_ms_60kb_5mbit", 1e3 * team.poses.age_s(0.99, start_s, end_s), "ms",
             "patches of 60 kB, 5 Mbit/s, 1 % loss");
  report.add("link.delivered_2s_percent_60kb_5mbit", team.patches.delivered_percent(2.0, start_s, end_s), "%");
}

void measure(Report& report) {
  const fs::path scratch = fs::temp_directory_path() / fmt::format("arpent_link_{}", getpid());
  fs::create_directories(scratch);
  std::vector<std::string> names;
  for (int i = 1; i <= kRobots; ++i) names.push_back(fmt::format("R{}", i));
  tools::make_keys({.out = scratch / "keys", .stations = names});
  {
    Team team(scratch, 50, kPatchBytes);
    const double start_s = now_s();
    team.meet();
    report.add("link.meet_s", now_s() - start_s, "s", "from the start of the processes, within 0.5 s");
    for (const int loss_percent : {5, 20}) measure_loss(report, team, loss_percent);
    measure_cut(report, team);
    measure_rejoin(report, team, 2, 8);
    measure_rejoin(report, team, 20, 8);
    report.add("link.corrupt", static_cast<double>(team.poses.bad() + team.patches.bad()), "1", "bar 0");
  }
  {
    Team team(scratch, 5, 60000);
    team.meet();
    measure_bulk(report, team);
  }
  fs::remove_all(scratch);
}

}  // namespace
}  // namespace arpent::bench

int main(int argc, char** argv) {
  if (const std::string reason = arpent::radio_network_refused(); !reason.empty()) {
    std::fprintf(stderr, "bench link needs network namespaces and TAP interfaces: %s\n", reason.c_str());
    return 1;
  }
  return arpent::bench::run(argc, argv, "The radio link between robots", arpent::bench::measure);
}
