// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <arpent/stereo_images_t.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/log/event_log.h"
#include "perception/stereo/depth.h"
#include "perception/stereo/rectifier.h"
#include "perception/stereo/wire.h"
#include "tools/report/mesh_view.h"
#include "tools/report/processes.h"

namespace arpent::tools {
namespace {

constexpr const char* kTruthColor = "#b5651d";
constexpr const char* kEstimateColor = "#0b8f87";

evaluation::Alignment alignment_for(const std::string& frame) {
  return frame == "cam0" ? evaluation::Alignment::kSe3 : evaluation::Alignment::kPosYaw;
}

std::int64_t count_lost(const ReplayResult& result) {
  return std::count_if(result.odometry.begin(), result.odometry.end(),
                       [](const auto& o) { return o.status == odometry::Status::kLost; });
}

/// The pairs of the log whose index `wanted` accepts, decoded.
template <class Wanted>
std::vector<stereo::StereoPair> load_pairs(const ReplayInput& input, const Wanted& wanted) {
  std::vector<stereo::StereoPair> pairs;
  LogReader reader(input.log);
  std::size_t index = 0;
  while (const auto event = reader.next()) {
    if (event->channel != channels::kStereoImages || !wanted(index++, event->time)) continue;
    stereo_images_t message;
    std::string fault;
    if (!decode_guarded(event->data, message, fault)) continue;
    if (auto pair = stereo::from_wire(message)) pairs.push_back(*pair);
  }
  return pairs;
}

std::optional<Pose> pose_at(const ReplayResult& result, Time stamp) {
  for (const auto& o : result.odometry) {
    if (o.stamp == stamp && o.status != odometry::Status::kLost) return o.T_odom_body;
  }
  return std::nullopt;
}

cv::Mat grey(const cv::Mat1b& image) {
  cv::Mat bgr;
  cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

std::vector<std::pair<cv::Mat, std::string>> depth_panels(const ReplayInput& input, const ReplayResult& result) {
  std::vector<std::pair<cv::Mat, std::string>> panels;
  const stereo::Rectifier rectifier(load_rig(input.rig_file).calibration);
  const auto matcher = stereo::make_matcher(input.config.depth.matcher);
  const std::size_t count = input.pairs.size();
  const double near_m = input.config.depth.min_range_m,
               far_m = std::min(input.config.depth.max_range_m, input.config.mapping.tsdf.max_range_m);
  for (const auto& pair :
       load_pairs(input, [&](std::size_t i, Time) { return i == count / 4 || i == 3 * count / 4; })) {
    if (pair.left.cols != rectifier.stereo().camera.width_px && !rectifier.is_identity()) continue;
    const auto [left, right] = rectifier.rectify(pair.left, pair.right);
    const auto disparities = matcher->match(left, right);
    const auto trusted =
        stereo::depth_from_disparity(disparities.trusted, disparities.sigma_px, rectifier.stereo(), near_m, far_m);
    const cv::Mat1f unit(left.size(), 1.0F);
    const auto filled = stereo::depth_from_disparity(disparities.filled, unit, rectifier.stereo(), near_m, far_m);
    panels.emplace_back(grey(left),
                        fmt::format("left image at {:.2f} s", to_seconds(pair.stamp - input.pairs.front())));
    panels.emplace_back(report::colour(trusted.depth_m, 0, far_m),
                        fmt::format("trusted depth, blue near to red at {:g} m, grey missing", far_m));
    panels.emplace_back(report::colour(filled.depth_m, 0, far_m), "filled depth");
    if (const auto T = pose_at(result, pair.stamp)) {
      panels.emplace_back(
          report::draw_from_camera(result.mesh, rectifier.stereo().camera, *T * rectifier.T_body_rectified()),
          "the finished map seen from there");
    }
  }
  return panels;
}

std::vector<std::pair<double, double>> plan(const evaluation::Trajectory& trajectory, bool camera_axes) {
  std::vector<std::pair<double, double>> points;
  for (const auto& pose : trajectory) {
    const auto& t = pose.T_ref_body.translation();
    points.emplace_back(camera_axes ? t.z() : t.x(), camera_axes ? -t.x() : t.y());
  }
  return points;
}

void add_trajectory(report::Page& page, const ReplayInput& input, const ReplayResult& result, const Summary& summary) {
  const std::string frame = input.config.trajectory_frame;
  page.section("Trajectory", summary.errors ? "Seen from above [m], the estimate laid upon the truth."
                                            : "Seen from above [m]. The truth is not known for this log.");
  std::vector<report::Curve> curves;
  if (summary.errors) curves.push_back({"truth", kTruthColor, plan(truth_of(input, frame), frame == "cam0")});
  curves.push_back(
      {"estimate", kEstimateColor,
       plan(summary.errors ? summary.errors->aligned : trajectory_of(result, input, frame), frame == "cam0")});
  page.plot(curves, "x [m]", "y [m]", true);
  if (!summary.errors) return;
  report::Curve error{"position error", kEstimateColor, {}};
  for (std::size_t i = 0; i < summary.errors->error_m.size(); ++i) {
    error.points.emplace_back(to_seconds(summary.errors->aligned[i].stamp - input.pairs.front()),
                              100 * summary.errors->error_m[i]);
  }
  page.plot({error}, "time [s]", "error [cm]", false);
}

}  // namespace

std::optional<double> measure_reprojection(const ReplayInput& input, const ReplayResult& result) {
  const stereo::Rectifier rectifier(load_rig(input.rig_file).calibration);
  const auto matcher = stereo::make_matcher(input.config.depth.matcher);
  const double Bf = rectifier.stereo().baseline_m * rectifier.stereo().camera.fx_px;
  std::int64_t bad = 0, all = 0;
  int taken = 0;
  const auto left_out = [&](std::size_t, Time stamp) {
    return !result.depth_crc.contains(to_utime(stamp)) && pose_at(result, stamp).has_value() && taken++ % 4 == 0;
  };
  for (const auto& pair : load_pairs(input, left_out)) {
    const auto [left, right] = rectifier.rectify(pair.left, pair.right);
    const auto disparities = matcher->match(left, right);
    const auto depth = stereo::depth_from_disparity(disparities.trusted, disparities.sigma_px, rectifier.stereo(),
                                                    input.config.depth.min_range_m, input.config.depth.max_range_m);
    const cv::Mat1f rendered = report::render_depth(result.mesh, rectifier.stereo().camera,
                                                    *pose_at(result, pair.stamp) * rectifier.T_body_rectified());
    for (int v = 0; v < rendered.rows; ++v) {
      for (int u = 0; u < rendered.cols; ++u) {
        if (depth.depth_m(v, u) <= 0) continue;
        ++all;
        const float z = rendered(v, u);
        bad += z <= 0 || std::abs(Bf / z - Bf / depth.depth_m(v, u)) > 2.0 ? 1 : 0;
      }
    }
  }
  if (all == 0) return std::nullopt;
  return 100.0 * static_cast<double>(bad) / static_cast<double>(all);
}

Summary summarise(const ReplayInput& input, const ReplayResult& result, const ReplayResult* live) {
  Summary summary;
  summary.warnings = input.warnings;
  const double duration_s = to_seconds(input.pairs.back() - input.pairs.front());
  auto& figures = summary.figures;
  figures.push_back({"stereo pairs", std::to_string(result.pairs), fmt::format("{:.1f} s of recording", duration_s)});
  if (!input.truth.empty() && result.odometry.size() > 1) {
    const std::string& frame = input.config.trajectory_frame;
    summary.errors =
        evaluation::evaluate(truth_of(input, frame), trajectory_of(result, input, frame), alignment_for(frame));
    figures.push_back({"trajectory error (ATE)", fmt::format("{:.3f} m", summary.errors->ate_m.rmse),
                       fmt::format("over {:.1f} m", summary.errors->path_m)});
    if (summary.errors->segments.segments > 0) {
      figures.push_back(
          {"relative drift", fmt::format("{:.2f} %", summary.errors->segments.t_rel_percent), "KITTI segments"});
    }
  }
  figures.push_back(
      {"odometry lost", fmt::format("{} pairs", count_lost(result)), fmt::format("of {}", result.odometry.size())});
  if (result.map) {
    figures.push_back({"depth images in the map", std::to_string(result.map->integrated),
                       fmt::format("{} passed over", result.map->rejected)});
    figures.push_back({"mesh", fmt::format("{} k triangles", result.mesh.triangles.size() / 1000),
                       fmt::format("voxels of {:g} m", result.map->voxel_m)});
  }
  if (result.cpu_s > 0) {
    figures.push_back({"speed", fmt::format("{:.1f} x real time", duration_s / result.wall_s),
                       fmt::format("{:.2f} s of CPU", result.cpu_s)});
  }
  // A part of the log, or every other pair, gives other messages.
  const bool whole = result.pairs == static_cast<std::int64_t>(input.pairs.size());
  if (const LogComparison log = compare_with_log(input, result); whole && log.compared > 0) {
    std::string remark = fmt::format("{} of {} messages differ", log.different, log.compared);
    for (const auto& [channel, count] : log.different_by_channel) remark += fmt::format(", {} {}", count, channel);
    if (log.further > 0) remark += fmt::format("; {} more behind the log's last", log.further);
    figures.push_back({"equal to the log", log.different == 0 ? "yes" : "no", remark});
  }
  if (live != nullptr) {
    summary.difference = compare(result, *live);
    figures.push_back({"live equals lockstep", summary.difference->identical() ? "yes" : "no",
                       fmt::format("{} depth, {} map states differ", summary.difference->depth_different,
                                   summary.difference->map_different)});
  }
  for (const auto& [name, process] : result.processes) {
    for (const auto& [message, count] : process.messages)
      summary.warnings.push_back(fmt::format("{}: {} ({} times)", name, message, count));
  }
  return summary;
}

void print(const Summary& summary) {
  for (const auto& f : summary.figures) fmt::print("  {:24} {:>16}   {}\n", f.name, f.value, f.remark);
  for (const auto& warning : summary.warnings) fmt::print("  warning: {}\n", warning);
}

void write_replay_report(const std::filesystem::path& folder, const ReplayInput& input, const ReplayResult& result,
                         const Summary& summary) {
  std::filesystem::create_directories(folder);
  write_ply(folder / "mesh.ply", result.mesh);
  evaluation::write_tum(folder / "trajectory.tum", trajectory_of(result, input, input.config.trajectory_frame));
  report::Page page("Replay of " + input.log.filename().string(),
                    "Stereo pairs through depth, odometry and mapping, in lockstep.");
  std::vector<report::Figure> figures = summary.figures;
  if (const auto bad2 = measure_reprojection(input, result)) {
    figures.push_back({"reprojection bad-2", fmt::format("{:.1f} %", *bad2), "map against depth of pairs left out"});
  }
  page.figures(figures);
  if (!summary.warnings.empty()) {
    page.section("Warnings");
    page.list(summary.warnings);
  }
  add_trajectory(page, input, result, summary);
  std::vector<report::ViewPath> paths(1);
  paths[0].color_bgr = cv::Scalar(40, 40, 220);
  for (const auto& o : result.odometry) paths[0].points_m.push_back(o.T_odom_body.translation());
  page.section("Map", "The surface from above, coloured by height; the path in red.");
  page.pictures({{report::draw_birds_eye(result.mesh, paths, {1280, 720}), "mesh.ply"}});
  page.section("Depth beside its image");
  page.pictures(depth_panels(input, result));
  report::add_processes(page, result.processes);
  page.write(folder);
}

}  // namespace arpent::tools
