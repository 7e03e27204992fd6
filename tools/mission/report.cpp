// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The report page of a mission: figures, paths from above, errors over time, what the cameras saw, the processes.
#include <fmt/format.h>

#include <arpent/stereo_images_t.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/atomic_file.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/log/event_log.h"
#include "common/pose2.h"
#include "perception/stereo/wire.h"
#include "tools/mission/report_reconstruction.h"
#include "tools/report/html.h"
#include "tools/report/mesh_view.h"
#include "tools/report/processes.h"

namespace arpent::tools {
namespace {

constexpr const char* kTruthColor = "#b5651d";
constexpr const char* kEstimateColor = "#0b8f87";
constexpr const char* kPlanColor = "#7a6fb0";
constexpr int kThumbnails = 8;
/// Curves in the page keep every so many points.
constexpr std::size_t kPlotPoints = 1500;

template <class T>
std::vector<T> thin_out(const std::vector<T>& all) {
  const std::size_t step = std::max<std::size_t>(1, all.size() / kPlotPoints);
  std::vector<T> few;
  for (std::size_t i = 0; i < all.size(); i += step) few.push_back(all[i]);
  return few;
}

report::Curve path_of(const std::string& name, const char* color, const evaluation::Trajectory& trajectory) {
  report::Curve curve{name, color, {}};
  for (const auto& pose : thin_out(trajectory)) {
    curve.points.emplace_back(pose.T_ref_body.translation().x(), pose.T_ref_body.translation().y());
  }
  return curve;
}

void add_paths(report::Page& page, const sim::World& world, const MissionResult& result) {
  page.section("Paths", "Seen from above, world frame [m].");
  std::vector<report::Curve> curves = outline(world);
  const char* name = "planned";
  for (const auto& path : result.paths) {
    if (path.points_m.empty()) continue;
    report::Curve planned{std::exchange(name, ""), kPlanColor, {}};
    for (const Eigen::Vector2d& p : path.points_m) planned.points.emplace_back(p.x(), p.y());
    curves.push_back(std::move(planned));
  }
  curves.push_back(path_of("true", kTruthColor, result.truth));
  curves.push_back(path_of("estimated", kEstimateColor, result.estimate));
  page.plot(curves, "x [m]", "y [m]", true);
}

void add_errors(report::Page& page, const MissionFigures& figures) {
  page.section("Errors of the pose", "Against the truth, in the world frame that the robot found by itself.");
  report::Curve position{"position", kEstimateColor, {}}, yaw{"heading", kPlanColor, {}};
  const std::size_t step = std::max<std::size_t>(1, figures.error_m.size() / kPlotPoints);
  for (std::size_t i = 0; i < figures.error_m.size(); i += step) {
    const double t = to_seconds(figures.estimate[i].stamp - figures.estimate.front().stamp);
    position.points.emplace_back(t, 100 * figures.error_m[i]);
    yaw.points.emplace_back(t, 180 / std::numbers::pi * figures.yaw_error_rad[i]);
  }
  page.plot({position}, "time [s]", "position error [cm]", false);
  page.plot({yaw}, "time [s]", "heading error [deg]", false);
}

std::vector<std::pair<cv::Mat, std::string>> thumbnails(const MissionResult& result) {
  std::vector<std::pair<cv::Mat, std::string>> pictures;
  const std::int64_t every = std::max<std::int64_t>(1, result.pairs / kThumbnails);
  std::int64_t index = 0;
  std::optional<Time> first;
  LogReader reader(result.log);
  while (const auto event = reader.next()) {
    if (event->channel != channels::kStereoImages) continue;
    if (!first) first = event->time;
    if (index++ % every != every / 2) continue;
    stereo_images_t message;
    std::string fault;
    if (!decode_guarded(event->data, message, fault)) continue;
    const auto pair = stereo::from_wire(message);
    if (!pair) continue;
    cv::Mat small, bgr;
    cv::resize(pair->left, small, {}, 0.5, 0.5, cv::INTER_AREA);
    cv::cvtColor(small, bgr, cv::COLOR_GRAY2BGR);
    pictures.emplace_back(bgr, fmt::format("left camera after {:.0f} s", to_seconds(event->time - *first)));
  }
  return pictures;
}

report::ViewPath driven(const MissionResult& result) {
  report::ViewPath path{{}, cv::Scalar(40, 40, 220)};
  for (const auto& pose : thin_out(result.truth)) path.points_m.push_back(pose.T_ref_body.translation());
  return path;
}

nlohmann::json to_json(const MissionSpec& spec, const MissionResult& result, const MissionFigures& f,
                       const std::optional<MissionEvaluation>& evaluation) {
  nlohmann::json rows = nlohmann::json::array();
  const auto add = [&](const char* name, double value, const char* unit) {
    rows.push_back({{"name", spec.name + "." + name}, {"value", value}, {"unit", unit}});
  };
  add("done", result.done() ? 1 : 0, "1");
  add("time_s", f.time_s, "s");
  add("path_m", f.path_m, "m");
  add("duty_cycle_percent", f.duty_cycle_percent, "%");
  add("ate_m", f.ate_m, "m");
  add("yaw_error_deg", f.yaw_error_deg, "deg");
  add("off_path_m", f.off_path_m, "m");
  add("collisions", f.collisions, "1");
  add("realtime_factor", f.realtime_factor, "1");
  if (evaluation) append_figures(rows, spec.name, *evaluation);
  return rows;
}

void write_plain(const std::filesystem::path& folder, const MissionSpec& spec, const MissionResult& result,
                 const MissionFigures& figures, const std::optional<MissionEvaluation>& evaluation) {
  evaluation::write_tum(folder / "truth.tum", result.truth);
  evaluation::write_tum(folder / "estimate.tum", result.estimate);
  if (!result.mesh.triangles.empty()) write_ply(folder / "mesh.ply", result.mesh);
  atomic_write(folder / "mission.json", to_json(spec, result, figures, evaluation).dump(1) + "\n");
}

}  // namespace

void write_mission_report(const std::filesystem::path& folder, const MissionSpec& spec, const MissionResult& result,
                          const MissionFigures& figures) {
  // Of a test drive the mesh is no more than a by-product.
  const MissionSetting setting = setting_of(spec, result);
  std::optional<MissionEvaluation> evaluation;
  if (spec.mission.kind == "explore" && !result.truth.empty()) {
    evaluation = evaluate_mission(setting, result, legal_views(setting));
  }
  write_plain(folder, spec, result, figures, evaluation);
  report::Page page("Mission " + spec.name, fmt::format("{} in {}, seed {}", spec.robot.stem().string(),
                                                        spec.world.stem().string(), spec.seed));
  const auto& last = result.reports.empty() ? planning::MissionReport{} : result.reports.back();
  page.figures(
      {{"mission", planning::describe(last.state), last.reason},
       {"time", fmt::format("{:.1f} s", figures.time_s), "from the start to the end"},
       {"way", fmt::format("{:.1f} m", figures.path_m), fmt::format("duty cycle {:.0f} %", figures.duty_cycle_percent)},
       {"pose error", fmt::format("{:.1f} cm", 100 * figures.ate_m),
        fmt::format("rms; {:.1f} cm at most, {:.2f} deg", 100 * figures.worst_error_m, figures.yaw_error_deg)},
       {"off the path", fmt::format("{:.1f} cm", 100 * figures.off_path_m),
        fmt::format("rms; {:.1f} cm at most", 100 * figures.worst_off_path_m)},
       {"collisions", std::to_string(figures.collisions), ""},
       {"speed", figures.realtime_factor > 0 ? fmt::format("{:.2f} x", figures.realtime_factor) : "live",
        "simulated time over CPU time, one core"}});
  if (evaluation) add_reconstruction(page, setting, result, *evaluation);
  add_paths(page, setting.world, result);
  add_errors(page, figures);
  if (!evaluation && !result.mesh.triangles.empty()) {
    page.section("The map", "The mesh from above.");
    page.pictures(
        {{report::draw_birds_eye(result.mesh, {driven(result)}, {1000, 700}), "the mesh, the way driven in red"}});
  }
  page.section("What the robot saw");
  page.pictures(thumbnails(result));
  report::add_processes(page, result.processes);
  page.write(folder);
}

}  // namespace arpent::tools
