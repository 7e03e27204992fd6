// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The report page of a team: figures, each robot's path, the fused map, time budgets, what crossed the radio.
#include <fmt/format.h>

#include <fstream>

#include "common/atomic_file.h"
#include "tools/mission/report_reconstruction.h"
#include "tools/mission/team_figures.h"
#include "tools/report/mesh_view.h"
#include "tools/report/processes.h"

namespace arpent::tools {
namespace {

/// Of the robots, in their order: in plots, and (BGR) in pictures.
constexpr std::array<const char*, 5> kColors{"#b5651d", "#0b8f87", "#7a6fb0", "#c0392b", "#5d8a2f"};
constexpr std::array<std::array<int, 3>, 5> kColorsBgr{
    {{29, 101, 181}, {135, 143, 11}, {176, 111, 122}, {43, 57, 192}, {47, 138, 93}}};
constexpr std::size_t kPlotPoints = 1500;

template <class T>
std::vector<T> thin_out(const std::vector<T>& all) {
  const std::size_t step = std::max<std::size_t>(1, all.size() / kPlotPoints);
  std::vector<T> few;
  for (std::size_t i = 0; i < all.size(); i += step) few.push_back(all[i]);
  return few;
}

void add_paths(report::Page& page, const TeamResult& result, const TeamFigures& figures) {
  page.section("Paths", "Driven, seen from above, world frame [m].");
  std::vector<report::Curve> curves = outline(figures.setting.world);
  for (std::size_t i = 0; i < result.robots.size(); ++i) {
    report::Curve curve{result.names[i], kColors[i % kColors.size()], {}};
    for (const auto& pose : thin_out(result.robots[i].truth)) {
      curve.points.emplace_back(pose.T_ref_body.translation().x(), pose.T_ref_body.translation().y());
    }
    curves.push_back(std::move(curve));
  }
  page.plot(curves, "x [m]", "y [m]", true);
}

void add_map(report::Page& page, const TeamResult& result, const TeamFigures& figures) {
  if (result.mesh.triangles.empty()) return;
  page.section("The fused map", "Of what all saw, against the true surface.");
  std::vector<report::ViewPath> paths;
  for (std::size_t i = 0; i < result.robots.size(); ++i) {
    const auto& bgr = kColorsBgr[i % kColorsBgr.size()];
    report::ViewPath path{{}, cv::Scalar(bgr[0], bgr[1], bgr[2])};
    for (const auto& pose : thin_out(result.robots[i].truth)) path.points_m.push_back(pose.T_ref_body.translation());
    paths.push_back(std::move(path));
  }
  add_pictures(page, figures.setting, result.mesh, paths, figures.evaluation);
}

void add_robots(report::Page& page, const TeamResult& result, const TeamFigures& figures) {
  page.section("Where the time went");
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < result.robots.size(); ++i) {
    const MissionFigures& f = figures.robots[i];
    const TimeBudget budget = time_budget(result.robots[i].commands);
    const auto& reports = result.robots[i].reports;
    const auto& last = reports.empty() ? planning::MissionReport{} : reports.back();
    const bool died = std::find(result.died.begin(), result.died.end(), result.names[i]) != result.died.end();
    rows.push_back({result.names[i], died ? "died" : planning::describe(last.state), fmt::format("{:.1f}", f.time_s),
                    fmt::format("{:.1f}", f.path_m), fmt::format("{:.1f}", budget.driving_s),
                    fmt::format("{:.1f}", budget.turning_s), fmt::format("{:.1f}", budget.creeping_s),
                    fmt::format("{:.1f}", budget.standing_s), fmt::format("{:.1f}", 100 * f.ate_m)});
  }
  page.table({"robot", "end", "time [s]", "way [m]", "driving [s]", "turning [s]", "creeping [s]", "standing [s]",
              "pose error [cm]"},
             rows);
}

/// The centre's tours in steps: what a robot holds stays so until the next one.
void add_allocation(report::Page& page, const TeamResult& result) {
  page.section("Allocation", "Viewpoints that the centre gave to each robot, over time [s].");
  std::vector<report::Curve> curves;
  for (std::size_t i = 0; i < result.robots.size(); ++i) {
    const MissionResult& robot = result.robots[i];
    if (robot.truth.empty()) continue;
    report::Curve curve{result.names[i], kColors[i % kColors.size()], {}};
    double held = 0;
    for (const Allotment& allotment : robot.allotments) {
      if (allotment.robot != result.names[i]) continue;
      const double time_s = to_seconds(allotment.stamp - robot.truth.front().stamp);
      curve.points.emplace_back(time_s, held);
      held = static_cast<double>(allotment.viewpoints);
      curve.points.emplace_back(time_s, held);
    }
    curves.push_back(std::move(curve));
  }
  page.plot(curves, "time [s]", "viewpoints", false);
}

void add_radio(report::Page& page, const TeamResult& result, double time_s) {
  page.section("The radio", "What was on the air, repairs and headers included.");
  std::vector<std::vector<std::string>> rows;
  for (const auto& [channel, bytes] : result.radio_bytes) {
    const auto size = static_cast<double>(bytes);
    rows.push_back(
        {channel, fmt::format("{:.3f}", 1e-6 * size), fmt::format("{:.2f}", 1e-3 * size / std::max(1.0, time_s))});
  }
  page.table({"channel", "MB", "kB/s"}, rows);
}

void write_plain(const std::filesystem::path& folder, const MissionSpec& spec, const TeamResult& result,
                 const TeamFigures& figures) {
  for (std::size_t i = 0; i < result.robots.size(); ++i) {
    evaluation::write_tum(folder / result.names[i] / "truth.tum", result.robots[i].truth);
    evaluation::write_tum(folder / result.names[i] / "estimate.tum", result.robots[i].estimate);
  }
  if (!result.mesh.triangles.empty()) write_ply(folder / "mesh.ply", result.mesh);
  atomic_write(folder / "mission.json", to_rows(spec, result, figures).dump(1) + "\n");
}

}  // namespace

void write_team_report(const std::filesystem::path& folder, const MissionSpec& spec, const TeamResult& result,
                       const TeamFigures& f) {
  write_plain(folder, spec, result, f);
  report::Page page("Mission " + spec.name,
                    fmt::format("{} x {} in {}, seed {}", result.names.size(), spec.robot.stem().string(),
                                spec.world.stem().string(), spec.seed));
  const evaluation::Reconstruction& r = f.evaluation.reconstruction;
  page.figures({{"mission", f.done ? "done" : "not done", ""},
                {"coverage", fmt::format("{:.1f} %", r.coverage_percent), "of the surface that can be seen"},
                {"RMSE", fmt::format("{:.2f} cm", r.errors.rmse_cm), "M3C2, covered surface"},
                {"time", fmt::format("{:.1f} s", f.time_s), "from the start to the end"},
                {"way", fmt::format("{:.1f} m", f.path_m), "all robots"},
                {"radio", fmt::format("{:.2f} MB", f.team_mb), "on the air"},
                {"collisions", std::to_string(f.collisions),
                 fmt::format("{} overlaps, least gap {:.2f} m", f.encounters.overlaps, f.encounters.least_gap_m)},
                {"plans", std::to_string(result.centre.plans), fmt::format("{} patches", result.centre.patches)}});
  add_paths(page, result, f);
  add_map(page, result, f);
  add_robots(page, result, f);
  add_allocation(page, result);
  add_radio(page, result, f.time_s);
  report::add_processes(page, result.processes);
  page.write(folder);
}

}  // namespace arpent::tools
