// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "common/pose2.h"

namespace arpent::tools {
namespace {

double distance_m(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double t = ab.squaredNorm() > 0 ? std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

double distance_m(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& path) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < path.size(); ++i) least = std::min(least, distance_m(p, path[i - 1], path[i]));
  return least;
}

double rms(const std::vector<double>& values) {
  double squares = 0;
  for (const double v : values) squares += v * v;
  return values.empty() ? 0 : std::sqrt(squares / static_cast<double>(values.size()));
}

double most(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

/// True distances from the path that was ordered last before each moment.
std::vector<double> distances_off_path(const MissionResult& result) {
  std::vector<double> distances;
  std::size_t order = 0;
  for (const auto& [stamp, T] : result.truth) {
    while (order + 1 < result.paths.size() && result.paths[order + 1].stamp <= stamp) ++order;
    if (result.paths.empty() || result.paths[order].stamp > stamp || result.paths[order].points_m.size() < 2) continue;
    distances.push_back(distance_m(to_pose2(T).position_m(), result.paths[order].points_m));
  }
  return distances;
}

void compare_with_truth(const MissionResult& result, MissionFigures& figures) {
  const auto pairs = evaluation::associate(result.truth, result.estimate);
  for (std::size_t i = 0; i < pairs.estimate.size(); ++i) {
    const Pose2 truth = to_pose2(pairs.reference[i].T_ref_body), estimate = to_pose2(pairs.estimate[i].T_ref_body);
    figures.estimate.push_back(pairs.estimate[i]);
    figures.error_m.push_back((estimate.position_m() - truth.position_m()).norm());
    figures.yaw_error_rad.push_back(wrap_angle(estimate.yaw_rad - truth.yaw_rad));
  }
  figures.ate_m = rms(figures.error_m);
  figures.worst_error_m = most(figures.error_m);
  figures.yaw_error_deg = 180 / std::numbers::pi * rms(figures.yaw_error_rad);
}

double length_m(const evaluation::Trajectory& trajectory) {
  double sum = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    sum += (trajectory[i].T_ref_body.translation() - trajectory[i - 1].T_ref_body.translation()).norm();
  }
  return sum;
}

/// From the report that the mission had begun to its last one.
double mission_time_s(const MissionResult& result) {
  const auto begun = std::find_if(result.reports.begin(), result.reports.end(),
                                  [](const auto& r) { return r.state != planning::MissionState::kWaiting; });
  return begun == result.reports.end() ? 0 : to_seconds(result.reports.back().stamp - begun->stamp);
}

}  // namespace

double duty_cycle_percent(const std::vector<StampedTwist>& commands) {
  const auto moves = [](const StampedTwist& c) {
    return c.commanded.speed_mps != 0 || c.commanded.turn_rate_radps != 0;
  };
  const auto first = std::find_if(commands.begin(), commands.end(), moves);
  const auto last = std::find_if(commands.rbegin(), commands.rend(), moves).base();
  if (first == commands.end()) return 0;
  const auto busy = std::count_if(first, last, [](const StampedTwist& c) {
    return std::abs(c.commanded.speed_mps) >= kDrivingMps || std::abs(c.commanded.turn_rate_radps) >= kTurningRadps;
  });
  return 100.0 * static_cast<double>(busy) / static_cast<double>(last - first);
}

MissionFigures measure(const MissionResult& result) {
  MissionFigures figures;
  figures.time_s = mission_time_s(result);
  figures.path_m = length_m(result.truth);
  figures.duty_cycle_percent = duty_cycle_percent(result.commands);
  compare_with_truth(result, figures);
  const std::vector<double> off_path = distances_off_path(result);
  figures.off_path_m = rms(off_path);
  figures.worst_off_path_m = most(off_path);
  if (result.cpu_s > 0 && result.truth.size() > 1) {
    figures.realtime_factor = to_seconds(result.truth.back().stamp - result.truth.front().stamp) / result.cpu_s;
  }
  figures.collisions = result.collisions;
  figures.estops = result.estops;
  return figures;
}

void print(const MissionFigures& f, const MissionResult& result) {
  const auto& last = result.reports.empty() ? planning::MissionReport{} : result.reports.back();
  std::printf("mission          %s%s%s\n", planning::describe(last.state), last.reason.empty() ? "" : ": ",
              last.reason.c_str());
  std::printf("time, way        %.1f s, %.1f m, duty cycle %.0f %%\n", f.time_s, f.path_m, f.duty_cycle_percent);
  std::printf("pose error       %.3f m rms, %.3f m at most, %.2f deg rms\n", f.ate_m, f.worst_error_m, f.yaw_error_deg);
  std::printf("off the path     %.3f m rms, %.3f m at most\n", f.off_path_m, f.worst_off_path_m);
  std::printf("collisions       %d\n", f.collisions);
  if (f.realtime_factor > 0) std::printf("speed            %.2f x real time on one core\n", f.realtime_factor);
}

int conclude(const char* program, const std::filesystem::path& folder, bool done, const std::string& log_fault) {
  std::printf("report           %s\n", std::filesystem::absolute(folder / "report.html").c_str());
  if (!log_fault.empty()) std::fprintf(stderr, "%s: %s\n", program, log_fault.c_str());
  return done && log_fault.empty() ? 0 : 1;
}

}  // namespace arpent::tools
