// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `tags`: the body's pose from ray-traced pictures of the tag cube, how honest its covariance is, what is
// accepted that must not be, and what a pair costs.
#include <Eigen/Cholesky>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "bench/harness.h"
#include "perception/tags/alignment.h"
#include "perception/tags/observer.h"
#include "tests/perception/tags/cube_pictures.h"

namespace arpent {
namespace {

using tags::PictureOptions;

constexpr int kViews = 100;
constexpr int kFalseViews = 40;  // per class of pictures
constexpr int kStandingViews = 20;

/// Errors of accepted observations against the truth.
struct Errors {
  std::vector<double> position_mm, yaw_mrad, nees;
  int rejected = 0;
};

tags::TagObserver make_observer() {
  return {{}, {}, {}, tags::make_stereo(), tags::make_T_body_cam()};
}

void add(Errors& errors, const tags::CubePair& pair, const tags::Observation& seen) {
  if (!seen.accepted()) {
    ++errors.rejected;
    return;
  }
  const Vector6d d = local(pair.T_world_body, seen.T_world_body);
  errors.position_mm.push_back(1e3 * d.head<3>().norm());
  errors.yaw_mrad.push_back(1e3 * std::abs(d[5]));
  const Vector6d raw = local(pair.T_world_body, seen.measured.T_world_body);
  errors.nees.push_back(raw.dot(seen.measured.covariance.ldlt().solve(raw)) / 6.0);
}

/// Pictures from `range_m`, around the bearing 0 by up to half of `spread_rad` to each side.
Errors measure(double range_m, double spread_rad, const PictureOptions& options) {
  const tags::TagObserver observer = make_observer();
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  Errors errors;
  for (int i = 0; i < kViews; ++i) {
    const double bearing_rad = spread_rad * uniform(generator);
    const Pose pose = tags::pose_facing({}, range_m, bearing_rad, 0.6 * uniform(generator));
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
  report.add("tags.accepted" + suffix, static_cast<double>(errors.nees.size()), "1", "of 100 views");
  if (errors.nees.empty()) return;
  report.add("tags.position_error_mm" + suffix, bench::median(errors.position_mm), "mm", with_bar ? "bar <= 10" : "");
  report.add("tags.yaw_error_mrad" + suffix, bench::median(errors.yaw_mrad), "mrad", with_bar ? "bar <= 5" : "");
  report.add("tags.nees" + suffix, mean(errors.nees), "1", "1 is honest");
}

/// Pictures that must not give a pose: no cube, other tags, other sizes, cards on the faces.
std::vector<PictureOptions> false_pictures() {
  std::vector<PictureOptions> classes(8);
  classes[0].with_cube = false;
  classes[1].painted_ids = {100, 101, 102, 103};
  classes[2].true_tag_m = 0.20;
  classes[3].true_tag_m = 0.23;
  for (std::size_t k = 4; k < 8; ++k) {
    classes[k].card_left = -0.2, classes[k].card_right = 1.2, classes[k].card_bottom = -0.2, classes[k].card_top = 1.2;
  }
  classes[4].card_right = 0.5;
  classes[5].card_bottom = 0.5;
  classes[6].card_left = 0.8;
  classes[7].card_left = 0.97, classes[7].card_right = 1.05, classes[7].card_grey = 18;
  return classes;
}

int count_false_accepts() {
  const tags::TagObserver observer = make_observer();
  int accepted = 0;
  for (const PictureOptions& options : false_pictures()) {
    for (int i = 0; i < kFalseViews; ++i) {
      const Pose pose = tags::pose_facing({}, 0.9 + 0.05 * i, 0.37 * i, 0.1);
      const auto pair = tags::render_cube({}, pose, static_cast<std::uint64_t>(i), options);
      accepted += observer.observe(pair.left, pair.right).accepted();
    }
  }
  return accepted;
}

/// A robot at rest before one face, as in the arena: error of the average of 20 views, and the share of the variance
/// that they have in common.
void measure_standing(bench::Report& report) {
  const tags::TagObserver observer = make_observer();
  std::vector<double> average_mm, shared;
  for (int place = 0; place < 15; ++place) {
    const Pose truth = tags::pose_facing({}, 1.0 + 0.1 * place, 0.12 * place, 0.05);
    tags::FrameAligner aligner({}, {});
    Vector6d sum = Vector6d::Zero();
    double squares = 0;
    for (int i = 0; i < kStandingViews; ++i) {
      const auto pair = tags::render_cube({}, truth, static_cast<std::uint64_t>(1000 * place + i));
      const auto seen = observer.observe(pair.left, pair.right);
      if (!seen.accepted()) continue;
      const Eigen::LLT<Matrix6d> llt(seen.measured.covariance);
      const Vector6d white = llt.matrixL().solve(local(truth, seen.measured.T_world_body));
      sum += white / kStandingViews;
      squares += white.squaredNorm() / kStandingViews;
      const auto alignment =
          aligner.add(tags::make_view(Time(std::chrono::milliseconds(200 * i)), seen.measured.T_world_body,
                                      seen.measured.covariance, Pose::Identity(), Matrix6d::Zero()));
      if (alignment && alignment->views == kStandingViews) {
        average_mm.push_back(1e3 * local(truth, alignment->T_world_odom).head<3>().norm());
      }
    }
    // E|mean|^2 = (shared + (1 - shared) / n) E|x|^2
    shared.push_back((sum.squaredNorm() / squares - 1.0 / kStandingViews) / (1 - 1.0 / kStandingViews));
  }
  report.add("tags.standing_error_mm", bench::median(average_mm), "mm", "average of 20 pairs, 1 to 2.4 m");
  report.add("tags.standing_shared", mean(shared), "1", "share of the variance that averaging does not lower");
}

void body(bench::Report& report) {
  cv::setNumThreads(1);
  report_errors(report, "", measure(2.0, 2 * M_PI, {}), true);
  report_errors(report, "_frontal", measure(2.0, 0.2, {}));
  report_errors(report, "_1m", measure(1.0, 2 * M_PI, {}));
  report_errors(report, "_3m", measure(3.0, 2 * M_PI, {}));
  report_errors(report, "_4m", measure(4.0, 2 * M_PI, {}));
  PictureOptions smeared;
  smeared.motion_px = 2;
  report_errors(report, "_smear_2px", measure(2.0, 2 * M_PI, smeared));
  PictureOptions soft;
  soft.lens_sigma_px = 0.9;
  report_errors(report, "_soft_lens", measure(2.0, 2 * M_PI, soft));
  report.add("tags.false_accepts", count_false_accepts(), "1", "bar 0, of 320 pictures");
  measure_standing(report);
  const auto pair = tags::render_cube({}, tags::pose_facing({}, 2.0, 0.6, 0.1), 1);
  const tags::TagObserver observer = make_observer();
  report.add_time(
      "tags.ms_pair", [&] { (void)observer.observe(pair.left, pair.right); }, 15);
  const tags::TagDetector detector({});
  report.add_time(
      "tags.ms_search", [&] { (void)detector.detect(pair.left); }, 15, "of it, the left image's search");
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "Tag cube: pose, honesty, cost", arpent::body);
}
