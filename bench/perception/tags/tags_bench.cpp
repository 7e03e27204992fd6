// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `tags`: the body's pose from ray-traced pictures of the tag cube, how honest its covariance is, what is
// accepted that must not be, and what a pair costs.
#include <algorithm>
#include <cmath>
#include <random>

#include "bench/harness.h"
#include "perception/tags/observer.h"
#include "tests/perception/tags/cube_pictures.h"

namespace arpent {
namespace {

using tags::PictureOptions;

constexpr int kViews = 100;

struct View {
  double range_m, bearing_rad, offset_rad;
};

/// Errors of accepted observations against the truth.
struct Errors {
  std::vector<double> position_mm, yaw_mrad, nees, ground_mm;
  std::vector<double> reduced_chi2;
  int rejected = 0;
};

tags::TagObserver make_observer() {
  return {{}, {}, {}, tags::make_stereo(), tags::make_T_body_cam()};
}

void add(Errors& errors, const tags::CubePair& pair, const tags::Observation& seen) {
  if (!seen.accepted()) {
    ++errors.rejected;
    if (std::getenv("TAGS_DEBUG")) std::printf("rejected: %s\n", seen.reason.c_str());
    return;
  }
  const Vector6d d = local(pair.T_world_body, seen.T_world_body);
  errors.position_mm.push_back(1e3 * d.head<3>().norm());
  errors.ground_mm.push_back(1e3 * d.head<2>().norm());
  errors.yaw_mrad.push_back(1e3 * std::abs(d[5]));
  const Vector6d raw = local(pair.T_world_body, seen.measured.T_world_body);
  errors.nees.push_back(raw.dot(seen.measured.covariance.ldlt().solve(raw)) / 6.0);
  errors.reduced_chi2.push_back(seen.measured.reduced_chi2);
}

Errors measure(double range_m, const std::function<double(double)>& bearing, const PictureOptions& options) {
  const tags::TagObserver observer = make_observer();
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  Errors errors;
  for (int i = 0; i < kViews; ++i) {
    const double bearing_rad = bearing(uniform(generator));
    const Pose pose = tags::pose_facing({}, range_m, bearing_rad, 0.6 * (uniform(generator) - 0.5));
    const auto pair = tags::render_cube({}, pose, static_cast<std::uint64_t>(i), options);
    add(errors, pair, observer.observe(pair.left, pair.right));
  }
  return errors;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v / static_cast<double>(values.size());
  return sum;
}

void report_errors(bench::Report& report, const std::string& suffix, const Errors& errors, bool with_bar = false) {
  if (errors.nees.empty()) {
    report.add("tags.rejected" + suffix, errors.rejected, "1");
    return;
  }
  report.add("tags.position_error_mm" + suffix, bench::median(errors.position_mm), "mm", with_bar ? "bar <= 10" : "");
  report.add("tags.yaw_error_mrad" + suffix, bench::median(errors.yaw_mrad), "mrad", with_bar ? "bar <= 5" : "");
  report.add("tags.nees" + suffix, mean(errors.nees), "1", "1 is honest");
  report.add("tags.chi2" + suffix, mean(errors.reduced_chi2), "1", "1 is honest");
  report.add("tags.rejected" + suffix, errors.rejected, "1");
}

void body(bench::Report& report) {
  cv::setNumThreads(1);
  const auto all_around = [](double u) { return 2 * M_PI * u; };
  const auto frontal = [](double u) { return 0.2 * (u - 0.5); };
  report_errors(report, "", measure(2.0, all_around, {}), true);
  report_errors(report, "_frontal", measure(2.0, frontal, {}));
  report_errors(report, "_1m", measure(1.0, all_around, {}));
  report_errors(report, "_3m", measure(3.0, all_around, {}));
  report_errors(report, "_4m", measure(4.0, all_around, {}));
  PictureOptions smeared;
  smeared.motion_px = 2;
  report_errors(report, "_smear_2px", measure(2.0, all_around, smeared));
  PictureOptions noiseless;
  noiseless.noise_levels = 0;
  report_errors(report, "_noiseless", measure(2.0, all_around, noiseless));
  const auto pair = tags::render_cube({}, tags::pose_facing({}, 2.0, 0.6, 0.1), 1);
  const tags::TagObserver observer = make_observer();
  report.add_time(
      "tags.ms_pair", [&] { (void)observer.observe(pair.left, pair.right); }, 15);
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "Tag cube: pose, honesty, cost", arpent::body);
}
