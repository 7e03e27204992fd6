// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `control`: the path tracker on a plant with lag, delay, a wrong yaw gain and pose noise, over paths with turns
// of 0.5 m radius: errors across the path and CPU time of a step; the dead man's switch of the base driver under random
// stops, on a fake clock and live; and the live emergency stop on a busy machine.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "bench/control/live_base.h"
#include "bench/harness.h"
#include "control/path_tracker.h"
#include "drivers/base/agilex_driver.h"
#include "drivers/can/memory_bus.h"
#include "tests/control/plant.h"

namespace arpent {
namespace {

using control::BaseState;
using control::Path;

constexpr double kPeriodS = 0.05;
constexpr double kPositionNoiseM = 0.005;
constexpr double kYawNoiseRad = 0.005;
constexpr int kSeeds = 10;

/// Straights of 2 m joined by U-turns of 0.5 m radius, alternately left and right.
std::vector<Eigen::Vector2d> lawn_mower(int straights) {
  constexpr double kRadiusM = 0.5, kStraightM = 2.0, kStepM = 0.01;
  std::vector<Eigen::Vector2d> points;
  double x = 0, y = 0, heading = 0;
  const auto drive = [&](double length, double curvature) {
    for (double s = 0; s < length; s += kStepM) {
      points.emplace_back(x, y);
      x += kStepM * std::cos(heading + 0.5 * kStepM * curvature);
      y += kStepM * std::sin(heading + 0.5 * kStepM * curvature);
      heading += kStepM * curvature;
    }
  };
  for (int i = 0; i < straights; ++i) {
    drive(kStraightM, 0);
    if (i + 1 < straights) drive(std::numbers::pi * kRadiusM, (i % 2 == 0 ? 1 : -1) / kRadiusM);
  }
  return points;
}

struct Errors {
  std::vector<double> across_m;
  std::vector<double> step_us;
  bool arrived = false;
};

/// True error: distance of the base (not of its noisy pose) from the path.
void run(unsigned seed, Errors& errors) {
  const control::TrackerParams params;
  const Path path(lawn_mower(6), params.limits);
  control::PathTracker tracker(params);
  tracker.follow(path, std::nullopt);
  control::Plant plant({}, {});
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  double s = 0;
  for (int i = 0; i < 2000; ++i) {
    BaseState measured = plant.state();
    measured.p_map_m += kPositionNoiseM * Eigen::Vector2d(normal(random), normal(random));
    measured.yaw_rad += kYawNoiseRad * normal(random);
    control::TrackerOutput output;
    errors.step_us.push_back(1e3 * bench::cpu_ms([&] { output = tracker.step(plant.state().stamp, measured); }));
    if (output.mode == control::TrackerMode::kArrived) {
      errors.arrived = true;
      return;
    }
    plant.move(output.command, kPeriodS);
    s = path.project(plant.state().p_map_m, s - 0.3, s + 1.0);
    errors.across_m.push_back((plant.state().p_map_m - path.at(s).p_m).norm());
  }
}

double quantile(std::vector<double> values, double q) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Random stops of a stream of commands: how often the first zero command left later than the dead man's time and one
/// cycle after the last command came, and the latest. On a fake clock, with cycles that jitter.
std::pair<int, double> dead_man(int stops) {
  constexpr double kCycleS = 0.02;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  can::MemoryBus bus;
  const auto port = bus.open("driver"), listener = bus.open("listener");
  base::AgilexDriver driver({}, *port);
  (void)driver.gate().arm();
  Time now = from_utime(1000000);
  Time last_command = now, next_command = now;
  int misses = 0;
  double latest_ms = 0;
  for (int stop = 0; stop < stops; ++stop) {
    const Time stop_at = now + from_seconds(0.05 + 0.4 * uniform(random));
    for (bool moving = true; moving || now < stop_at;) {
      now += from_seconds(kCycleS * (0.9 + 0.1 * uniform(random)));
      for (; next_command <= now && next_command < stop_at; next_command += from_seconds(0.1 * uniform(random))) {
        if (!driver.gate().offer({0.3, 0}, next_command)) last_command = next_command;
      }
      bus.advance(now);
      (void)driver.step(now);
      bus.advance(now + from_seconds(0.001));
      while (const auto heard = listener->receive()) {
        if (const auto motion = base::agilex::decode_motion(heard->frame)) moving = motion->speed_mps != 0;
      }
    }
    const double ms = 1e3 * to_seconds(now - last_command);
    latest_ms = std::max(latest_ms, ms);
    misses += ms > 200 + 1e3 * kCycleS ? 1 : 0;
    next_command = now;
    last_command = now;
    (void)driver.gate().offer({}, now);
  }
  return {misses, latest_ms};
}

void body(bench::Report& report) {
  const auto [misses, latest_ms] = dead_man(100000);
  report.add("deadman.misses", misses, "1", "bar 0; of 100000 stops on a fake clock");
  report.add("deadman.latest_ms", latest_ms, "ms");
  bench::time_live_base(report);
  Errors errors;
  int arrived = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    errors.arrived = false;
    run(seed, errors);
    arrived += errors.arrived ? 1 : 0;
  }
  double squares = 0;
  for (const double e : errors.across_m) squares += e * e;
  report.add("mpc.crosstrack_rms_mm", 1e3 * std::sqrt(squares / static_cast<double>(errors.across_m.size())), "mm",
             "bar <= 8");
  report.add("mpc.crosstrack_max_mm", 1e3 * *std::max_element(errors.across_m.begin(), errors.across_m.end()), "mm",
             "bar <= 25");
  report.add("mpc.arrived", arrived, "1", "of 10 runs");
  report.add("mpc.solve_us_median", quantile(errors.step_us, 0.5), "us");
  report.add("mpc.solve_us_p99", quantile(errors.step_us, 0.99), "us");
  std::vector<double> reference_ms;
  for (int i = 0; i < 5; ++i) reference_ms.push_back(bench::time_reference_once());
  report.add("mpc.solve_p99_over_ref", quantile(errors.step_us, 0.99) / 1e3 / bench::median(reference_ms), "1",
             "bar <= 0.005");
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "The path tracker", arpent::body);
}
