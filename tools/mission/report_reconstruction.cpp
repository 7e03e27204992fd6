// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/report_reconstruction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/atomic_file.h"
#include "sim/world/ground.h"
#include "tools/mission/map_growth.h"
#include "tools/report/mesh_view.h"

namespace arpent::tools {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

constexpr const char* kWallColor = "#9aa5b0";
constexpr const char* kCoverageColor = "#0b8f87";
constexpr const char* kIncompleteColor = "#b5651d";
constexpr Rgb kFound{205, 213, 214}, kMissed{214, 40, 40}, kHidden{120, 126, 134}, kGhost{150, 60, 170};
const cv::Scalar kPathBgr(40, 40, 220);
constexpr int kMoments = 30;
constexpr double kFilmSeconds = 8;
const cv::Size kPicture(1000, 700), kFrame(520, 364);

/// Blue behind the true surface, red in front of it, white on it.
Rgb error_color(float error_m, double limit_m) {
  if (std::isnan(error_m)) return kGhost;
  const double share = std::clamp(static_cast<double>(error_m) / limit_m, -1.0, 1.0);
  const auto fade = static_cast<std::uint8_t>(235 - 195 * std::abs(share));
  return share > 0 ? Rgb{235, fade, fade} : Rgb{fade, fade, 235};
}

TriangleMesh color_by_error(const TriangleMesh& mesh, const TriangleMesh& truth, double limit_m) {
  TriangleMesh colored = mesh;
  colored.colors_rgb.clear();
  for (const float error : evaluation::vertex_errors(truth, mesh, limit_m))
    colored.colors_rgb.push_back(error_color(error, limit_m));
  return colored;
}

/// A small square on the surface.
void add_tile(TriangleMesh& mesh, const Eigen::Vector3d& p, const Eigen::Vector3d& normal, const Rgb& color) {
  constexpr float kHalfM = 0.022F;
  const Eigen::Vector3f n = normal.cast<float>(), u = kHalfM * n.unitOrthogonal(), v = n.cross(u);
  const Eigen::Vector3f centre = p.cast<float>();
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (const Eigen::Vector3f& d :
       {Eigen::Vector3f(-u - v), Eigen::Vector3f(u - v), Eigen::Vector3f(u + v), Eigen::Vector3f(v - u)}) {
    mesh.vertices_m.emplace_back(centre + d);
    mesh.colors_rgb.push_back(color);
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

TriangleMesh color_by_coverage(const MissionEvaluation& evaluation) {
  // Tiles just above the surface, what is missing above all.
  constexpr double kHiddenAboveM = 0.002, kMissedAboveM = 0.004;
  const evaluation::TrueSurface& truth = evaluation.truth;
  TriangleMesh mesh = truth.mesh;
  mesh.colors_rgb.assign(mesh.vertices_m.size(), kFound);
  const auto add = [&mesh](const evaluation::Samples& samples, std::size_t i, double above_m, const Rgb& color) {
    add_tile(mesh, samples.points_m[i] + above_m * samples.normals[i], samples.normals[i], color);
  };
  for (std::size_t i = 0; i < truth.hidden.points_m.size(); ++i) add(truth.hidden, i, kHiddenAboveM, kHidden);
  for (std::size_t i = 0; i < truth.visible.points_m.size(); ++i) {
    if (evaluation.reconstruction.covered[i] == 0) add(truth.visible, i, kMissedAboveM, kMissed);
  }
  return mesh;
}

report::ViewPath driven(const MissionResult& result, Time until) {
  report::ViewPath path{{}, kPathBgr};
  for (const auto& [stamp, T] : result.truth) {
    if (stamp <= until) path.points_m.push_back(T.translation());
  }
  return path;
}

struct Growth {
  report::Curve coverage{"surface covered", kCoverageColor, {}},
      incomplete{"incomplete elements", kIncompleteColor, {}};
  std::vector<cv::Mat> frames;
  std::int64_t fused = 0;
};

Growth grow(const MissionSetting& setting, const MissionResult& result, const MissionEvaluation& evaluation) {
  Growth growth;
  const Eigen::AlignedBox3f box = setting.world.region.box_m().cast<float>();
  const Time begin = result.truth.front().stamp;
  growth.fused = replay_map(result.log, setting, kMoments, [&](const MapMoment& moment) {
    const double t = to_seconds(moment.stamp - begin);
    growth.coverage.points.emplace_back(t,
                                        evaluation::coverage_percent(evaluation.truth, moment.mesh, setting.voxel_m()));
    growth.incomplete.points.emplace_back(t, static_cast<double>(moment.incomplete));
    cv::Mat frame = report::draw_open(moment.mesh, {driven(result, moment.stamp)}, box, kFrame);
    cv::putText(frame, fmt::format("{:.0f} s", t), {12, 26}, cv::FONT_HERSHEY_SIMPLEX, 0.6, {60, 60, 60}, 1,
                cv::LINE_AA);
    growth.frames.push_back(frame);
  });
  return growth;
}

void add_figures(report::Page& page, const MissionEvaluation& evaluation) {
  const evaluation::Reconstruction& r = evaluation.reconstruction;
  page.figures({{"coverage", fmt::format("{:.1f} %", r.coverage_percent),
                 fmt::format("of the surface that can be seen, within {:.2f} cm", 100 * r.e_max_m)},
                {"error", fmt::format("{:.2f} cm", r.errors.rmse_cm),
                 fmt::format("rms; mean {:+.2f}, deviation {:.2f} cm (M3C2)", r.errors.mean_cm, r.errors.std_cm)},
                {"ghosts", fmt::format("{:.1f} %", r.beyond_percent), "of the mesh, farther from any true surface"},
                {"surface", fmt::format("{:.0f} m²", evaluation.truth.area_m2),
                 fmt::format("{:.1f} % of it can be seen from legal poses", evaluation.truth.visible_percent())}});
}

void add_budget(report::Page& page, const MissionResult& result) {
  const TimeBudget budget = time_budget(result.commands);
  const double all_s = budget.driving_s + budget.turning_s + budget.creeping_s + budget.standing_s;
  if (all_s <= 0) return;
  page.section("Where the time went", "By what the base was told, from the first motion to the last.");
  const auto row = [&](const char* name, double s) {
    return std::vector<std::string>{name, fmt::format("{:.1f}", s), fmt::format("{:.1f}", 100 * s / all_s)};
  };
  page.table(
      {"", "time [s]", "share [%]"},
      {row("driving (0.2 m/s and more)", budget.driving_s), row("turning (0.5 rad/s and more)", budget.turning_s),
       row("slower than either", budget.creeping_s), row("standing", budget.standing_s)});
}

}  // namespace

void add_pictures(report::Page& page, const MissionSetting& setting, const TriangleMesh& mesh,
                  const std::vector<report::ViewPath>& ways, const MissionEvaluation& evaluation) {
  const Eigen::AlignedBox3f box = setting.world.region.box_m().cast<float>();
  const double limit_m = evaluation.reconstruction.e_max_m;
  page.pictures({{report::draw_open(mesh, ways, box, kPicture),
                  "the mesh from above, what faces away left out; with the ways driven"},
                 {report::draw_open(color_by_error(mesh, evaluation.truth.mesh, limit_m), {}, box, kPicture),
                  fmt::format("signed error: red in front of the true surface, blue behind it, full colour at {:.1f} "
                              "cm; violet: farther",
                              100 * limit_m)},
                 {report::draw_open(color_by_coverage(evaluation), {}, box, kPicture),
                  "the true surface: found (light), missed (red), never to be seen (dark)"}});
}

std::vector<report::Curve> outline(const sim::World& world) {
  const sim::GroundMap ground(world);
  std::vector<report::Curve> curves;
  for (const auto& polygon : ground.obstacles()) {
    report::Curve curve{"", kWallColor, {}};
    for (const Eigen::Vector2d& p : polygon) curve.points.emplace_back(p.x(), p.y());
    curve.points.push_back(curve.points.front());
    curves.push_back(std::move(curve));
  }
  return curves;
}

TimeBudget time_budget(const std::vector<StampedTwist>& commands) {
  TimeBudget budget;
  const auto moves = [](const StampedTwist& c) {
    return c.commanded.speed_mps != 0 || c.commanded.turn_rate_radps != 0;
  };
  double standing_s = 0;  // since the last motion: counts once there is another
  for (std::size_t i = 0; i + 1 < commands.size(); ++i) {
    const StampedTwist& c = commands[i];
    const double s = to_seconds(commands[i + 1].stamp - c.stamp);
    const bool begun = budget.driving_s + budget.turning_s + budget.creeping_s > 0;
    if (!moves(c)) {
      standing_s += begun ? s : 0;
      continue;
    }
    budget.standing_s += std::exchange(standing_s, 0);
    const bool drives = std::abs(c.commanded.speed_mps) >= kDrivingMps;
    const bool turns = std::abs(c.commanded.turn_rate_radps) >= kTurningRadps;
    (drives ? budget.driving_s : turns ? budget.turning_s : budget.creeping_s) += s;
  }
  return budget;
}

void add_reconstruction(report::Page& page, const MissionSetting& setting, const MissionResult& result,
                        const MissionEvaluation& evaluation) {
  page.section("The reconstruction", "Against the true surface of " + setting.world.name +
                                         ", without what no legal pose of the robot's camera could ever see.");
  add_figures(page, evaluation);
  add_pictures(page, setting, result.mesh, {driven(result, result.truth.back().stamp)}, evaluation);
  const Growth growth = grow(setting, result, evaluation);
  page.section("How the map grew", fmt::format("{} depth images, fused once more from the log.", growth.fused));
  page.film(growth.frames, kFilmSeconds, "the map from above over the mission");
  page.plot({growth.coverage}, "time [s]", "coverage [%]", false);
  page.plot({growth.incomplete}, "time [s]", "incomplete surface elements", false);
  add_budget(page, result);
}

void write_reconstruction_report(const std::filesystem::path& folder, const std::filesystem::path& world,
                                 const std::filesystem::path& out) {
  const MissionFolder mission = read_mission_folder(folder, world);
  const MissionEvaluation evaluation = evaluate_mission(mission.setting, mission.result, legal_views(mission.setting));
  report::Page page("Mission " + mission.setting.name, "in " + mission.setting.world.name);
  add_reconstruction(page, mission.setting, mission.result, evaluation);
  page.write(out);
}

void write_growth(const std::filesystem::path& folder, const std::filesystem::path& world,
                  const std::filesystem::path& csv) {
  const MissionFolder mission = read_mission_folder(folder, world);
  const MissionEvaluation evaluation = evaluate_mission(mission.setting, mission.result, legal_views(mission.setting));
  std::string text = "time_s,path_m,coverage_percent,incomplete_elements\n";
  const evaluation::Trajectory& truth = mission.result.truth;
  double path_m = 0;
  std::size_t next = 1;  // of the truth, not yet in path_m: moments come in order
  replay_map(mission.result.log, mission.setting, kMoments, [&](const MapMoment& moment) {
    for (; next < truth.size() && truth[next].stamp <= moment.stamp; ++next) {
      path_m += (truth[next].T_ref_body.translation() - truth[next - 1].T_ref_body.translation()).norm();
    }
    text += fmt::format("{:.2f},{:.2f},{:.2f},{}\n", to_seconds(moment.stamp - truth.front().stamp), path_m,
                        evaluation::coverage_percent(evaluation.truth, moment.mesh, mission.setting.voxel_m()),
                        moment.incomplete);
  });
  atomic_write(csv, text);
}

}  // namespace arpent::tools
