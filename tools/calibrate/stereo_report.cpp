// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/stereo_report.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "tools/report/html.h"

namespace arpent::tools {
namespace {

using calib::Calibration;
using calib::Quality;

const char* const* lens_names(const RawCamera& camera) {
  return camera.distortion == DistortionModel::kEquidistant ? calib::kEquidistantNames : calib::kRadialTangentialNames;
}

std::string verdict(const Quality& quality) {
  switch (quality.grade) {
    case calib::Grade::kGood:
      return "Good: use it.";
    case calib::Grade::kUsable:
      return "Usable, and could be better:";
    case calib::Grade::kBad:
      break;
  }
  return "Bad: do not use it.";
}

/// Residuals as needles, a hundred times as long as they are.
cv::Mat3b draw_residuals(const Calibration& calibration, std::size_t c) {
  constexpr double kMagnify = 100;
  const PinholeCamera& p = calibration.rig.cameras[c].pinhole;
  cv::Mat3b picture(p.height_px, p.width_px, cv::Vec3b(255, 255, 255));
  for (const calib::Residual& r : calibration.residuals) {
    if (r.observation.camera != static_cast<int>(c)) continue;
    const Eigen::Vector2d a = r.observation.px, b = a + kMagnify * r.error_px;
    cv::line(picture, cv::Point2d(a.x(), a.y()), cv::Point2d(b.x(), b.y()), cv::Scalar(120, 60, 20), 1, cv::LINE_AA);
  }
  return picture;
}

cv::Mat3b enlarge(const cv::Mat1f& fields, double most) {
  cv::Mat3b small = report::colour(fields, 0, most), large;
  cv::resize(small, large, {}, 48, 48, cv::INTER_NEAREST);
  return large;
}

void add_cameras(report::Page& page, const Calibration& calibration, const Quality& quality) {
  for (std::size_t c = 0; c < quality.cameras.size(); ++c) {
    const auto& camera = quality.cameras[c];
    page.section(calibration.views.cameras[c].name);
    const auto lens = calib::to_parameters(calibration.rig.cameras[c]);
    std::vector<std::vector<std::string>> rows;
    for (std::size_t k = 0; k < lens.size(); ++k) {
      const auto parameter = static_cast<Eigen::Index>(calib::kLensParameters * c + k);
      rows.push_back({lens_names(calibration.rig.cameras[c])[k], fmt::format("{:.6g}", lens[k]),
                      fmt::format("{:.2g}", calibration.deviation(parameter))});
    }
    page.table({"parameter", "value", "standard deviation"}, rows);
    double most = 0;
    cv::minMaxLoc(camera.coverage, nullptr, &most);
    std::vector<std::pair<cv::Mat, std::string>> pictures{
        {enlarge(camera.coverage, most), fmt::format("corners per field, up to {:.0f}; grey: none", most)},
        {draw_residuals(calibration, c), "errors of the corners, 100 times as long"}};
    if (!camera.uncertainty_px.empty()) {
      pictures.emplace_back(
          enlarge(camera.uncertainty_px, std::max(0.05, camera.worst_uncertainty_px)),
          fmt::format("standard deviation of a projection, up to {:.3f} px", camera.worst_uncertainty_px));
    }
    page.pictures(pictures);
  }
}

void add_views(report::Page& page, const Calibration& calibration) {
  page.section("Views", "Root mean square error [px] of each view. Left out views are listed at the end.");
  std::vector<std::string> head{"view"};
  for (const auto& camera : calibration.views.cameras) head.push_back(camera.name);
  std::vector<std::vector<std::string>> rows;
  const auto rms_px = calib::rms_by_view(calibration);
  for (std::size_t v = 0; v < rms_px.size(); ++v) {
    auto& row = rows.emplace_back(std::vector<std::string>{calibration.views.views[v].name});
    for (const auto& value : rms_px[v]) row.push_back(value ? fmt::format("{:.3f}", *value) : "-");
  }
  page.table(head, rows);
  std::vector<std::string> rejected;
  for (const auto& r : calibration.rejected_views)
    rejected.push_back(fmt::format("{} of {}: {:.2f} px", r.view, r.camera, r.rms_px));
  if (!rejected.empty()) page.list(rejected);
}

}  // namespace

std::string summarize(const Calibration& calibration, const Quality& quality) {
  std::string text;
  for (std::size_t c = 0; c < quality.cameras.size(); ++c) {
    const PinholeCamera& p = calibration.rig.cameras[c].pinhole;
    const auto k = static_cast<Eigen::Index>(calib::kLensParameters * c);
    text += fmt::format(
        "{}: f {:.2f} +- {:.2f}, {:.2f} +- {:.2f} px; centre {:.2f} +- {:.2f}, {:.2f} +- {:.2f} px; rms {:.3f} px\n",
        calibration.views.cameras[c].name, p.fx_px, calibration.deviation(k), p.fy_px, calibration.deviation(k + 1),
        p.cx_px, calibration.deviation(k + 2), p.cy_px, calibration.deviation(k + 3), quality.cameras[c].rms_px);
    if (c == 0) continue;
    text += fmt::format("   {:.3f} +- {:.3f} mm from {}\n", 1e3 * calibration.baseline_m(c),
                        1e3 * calibration.baseline_deviation_m(c), calibration.views.cameras[0].name);
  }
  if (quality.cameras.size() > 1) text += fmt::format("epipolar error {:.3f} px\n", quality.epipolar_rms_px);
  for (const auto& r : calibration.rejected_views)
    text += fmt::format("left out: {} of {} ({:.2f} px)\n", r.view, r.camera, r.rms_px);
  if (calibration.rejected_corners > 0)
    text += fmt::format("left out: {} single corners\n", calibration.rejected_corners);
  text += fmt::format("{} views, {} corners. {}\n", calibration.views.views.size(), calibration.residuals.size(),
                      verdict(quality));
  for (const std::string& line : quality.advice) text += "  - " + line + "\n";
  return text;
}

nlohmann::json to_json(const Calibration& calibration, const Quality& quality) {
  nlohmann::json out{{"verdict", calib::to_text(quality.grade)},
                     {"advice", quality.advice},
                     {"views", calibration.views.views.size()},
                     {"corners", calibration.residuals.size()},
                     {"rejected_corners", calibration.rejected_corners},
                     {"rms_px", calibration.rms_px},
                     {"epipolar_rms_px", quality.epipolar_rms_px},
                     {"holdout_ratio", quality.holdout_ratio},
                     {"tilt_deg", quality.tilt_deg}};
  for (const auto& r : calibration.rejected_views) {
    out["rejected_views"].push_back({{"view", r.view}, {"camera", r.camera}, {"rms_px", r.rms_px}});
  }
  for (std::size_t c = 0; c < quality.cameras.size(); ++c) {
    const auto& q = quality.cameras[c];
    nlohmann::json camera{{"name", calibration.views.cameras[c].name},
                          {"rms_px", q.rms_px},
                          {"coverage_percent", q.coverage_percent},
                          {"worst_uncertainty_px", q.worst_uncertainty_px}};
    const auto lens = calib::to_parameters(calibration.rig.cameras[c]);
    for (std::size_t k = 0; k < lens.size(); ++k) {
      const std::string name = lens_names(calibration.rig.cameras[c])[k];
      camera[name] = lens[k];
      camera["deviation_" + name] = calibration.deviation(static_cast<Eigen::Index>(calib::kLensParameters * c + k));
    }
    if (c > 0) {
      camera["baseline_m"] = calibration.baseline_m(c);
      camera["deviation_baseline_m"] = calibration.baseline_deviation_m(c);
    }
    out["cameras"].push_back(camera);
  }
  return out;
}

void write_report(const Calibration& calibration, const Quality& quality, const std::filesystem::path& folder) {
  report::Page page("Calibration", verdict(quality));
  std::vector<report::Figure> figures{
      {"error (rms)", fmt::format("{:.3f} px", calibration.rms_px),
       fmt::format("noise {:.3f} px per coordinate", calibration.sigma_px)},
      {"views", fmt::format("{}", calibration.views.views.size()),
       fmt::format("{} corners", calibration.residuals.size())},
      {"tilt", fmt::format("{:.0f} deg", quality.tilt_deg), "between two views, at most"}};
  if (quality.cameras.size() > 1) {
    figures.push_back({"baseline", fmt::format("{:.2f} mm", 1e3 * calibration.baseline_m(1)),
                       fmt::format("+- {:.3f} mm", 1e3 * calibration.baseline_deviation_m(1))});
    figures.push_back({"epipolar error", fmt::format("{:.3f} px", quality.epipolar_rms_px), "rms, after undistortion"});
  }
  if (quality.holdout_ratio > 0)
    figures.push_back(
        {"hold-out", fmt::format("{:.2f}", quality.holdout_ratio), "error of views not used over that of views used"});
  page.figures(figures);
  page.list(quality.advice);
  add_cameras(page, calibration, quality);
  add_views(page, calibration);
  page.write(folder);
}

}  // namespace arpent::tools
