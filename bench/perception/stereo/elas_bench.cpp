// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `elas`: the stereo matcher on public pairs with ground truth ($ARPENT_DATA/stereo): accuracy, time, cost growth
// with the disparity range, determinism; and rectification. Without the data the times are those of a synthetic pair.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "bench/harness.h"
#include "bench/perception/stereo/public_pairs.h"
#include "perception/stereo/matcher.h"
#include "perception/stereo/rectifier.h"

namespace arpent {
namespace {

using bench::PublicPair;

stereo::MatcherParams params_for(int range_px, int threads = 1) {
  stereo::MatcherParams params;
  params.algorithm = "elas";
  params.max_disparity_px = range_px;
  params.threads = threads;
  return params;
}

stereo::Disparities match(const PublicPair& pair) {
  return stereo::make_matcher(params_for(pair.range_px))->match(pair.left, pair.right);
}

/// 68 % quantile of |error| / stated standard deviation over trusted pixels: 1 if the deviation is honest.
double sigma_ratio(const std::vector<PublicPair>& pairs) {
  std::vector<double> ratios;
  for (const PublicPair& pair : pairs) {
    const stereo::Disparities disparities = match(pair);
    for (int v = 0; v < pair.left.rows; ++v) {
      for (int u = 0; u < pair.left.cols; ++u) {
        const std::uint16_t d = disparities.trusted(v, u);
        if (pair.evaluated(v, u) == 0 || d == stereo::kMissing) continue;
        ratios.push_back(std::abs(d / stereo::kUnitsPerPixel - pair.truth_px(v, u)) / disparities.sigma_px(v, u));
      }
    }
  }
  const auto at = ratios.begin() + static_cast<std::ptrdiff_t>(0.68 * static_cast<double>(ratios.size()));
  std::nth_element(ratios.begin(), at, ratios.end());
  return *at;
}

void measure_accuracy(bench::Report& report, const std::vector<PublicPair>& pairs) {
  double filled = 0, trusted = 0, density = 0;
  for (const PublicPair& pair : pairs) {
    const stereo::Disparities disparities = match(pair);
    const bench::Score f = bench::score(pair, disparities.filled);
    const bench::Score t = bench::score(pair, disparities.trusted);
    char note[96];
    std::snprintf(note, sizeof note, "trusted: %.2f %% wrong at %.1f %%, mean error %.2f px", t.bad2_est_percent,
                  t.density_percent, t.average_px);
    if (pair.name == "terrace") {
      report.add("elas.bad2_all_filled_terrace", f.bad2_all_percent, "%", std::string("bar <= 4.6; ") + note);
      continue;
    }
    report.add("elas.bad2_all_filled." + pair.name, f.bad2_all_percent, "%", note);
    filled += f.bad2_all_percent / 5;
    trusted += t.bad2_est_percent / 5;
    density += t.density_percent / 5;
  }
  report.add("elas.bad2_all_filled", filled, "%", "bar <= 4.4 (padded SGBM 4.4, libelas 5.1)");
  report.add("elas.bad2_est_trusted", trusted, "%", "bar <= 1.8 (padded SGBM 2.5)");
  report.add("elas.density_trusted", density, "%", "bar >= 92 (padded SGBM 98)");
  report.add("elas.sigma_ratio", sigma_ratio(pairs), "1", "reported; 1 is honest");
  const PublicPair noisy = bench::with_noise(bench::scaled(pairs[4], {640, 512}, 64), 5, 1);
  report.add("elas.bad2_noise5", bench::score(noisy, match(noisy).filled).bad2_all_percent, "%",
             "bar <= 12.2 (libelas 12.2, SGBM 19.4)");
}

bool same(const stereo::Disparities& a, const stereo::Disparities& b) {
  const auto equal = [](const cv::Mat& x, const cv::Mat& y) { return cv::norm(x, y, cv::NORM_INF) == 0; };
  return equal(a.filled, b.filled) && equal(a.trusted, b.trusted) && equal(a.sigma_px, b.sigma_px);
}

/// The same bytes from a used and a new matcher, and with one, two and three threads; nothing from a pair without
/// texture.
bool is_deterministic(const PublicPair& pair, const PublicPair& other) {
  const stereo::Disparities expected = match(pair);
  for (const int threads : {1, 2, 3}) {
    const auto matcher = stereo::make_matcher(params_for(pair.range_px, threads));
    (void)matcher->match(other.left, other.right);
    if (!same(matcher->match(pair.left, pair.right), expected)) return false;
  }
  const cv::Mat1b blank(pair.left.size(), std::uint8_t{90});
  const auto matcher = stereo::make_matcher(params_for(pair.range_px));
  const stereo::Disparities none = matcher->match(blank, blank);
  return cv::countNonZero(none.filled != stereo::kMissing) == 0 &&
         cv::countNonZero(none.trusted != stereo::kMissing) == 0 && cv::countNonZero(none.sigma_px) == 0;
}

void measure_times(bench::Report& report, const PublicPair& pair) {
  const auto time_range = [&](int range_px, const std::string& name, const std::string& note) {
    const auto matcher = stereo::make_matcher(params_for(range_px));
    return report.add_time(
        name, [&] { (void)matcher->match(pair.left, pair.right); }, 9, note);
  };
  time_range(128, "elas.ms_640x512_d128", "bar <= 0.6");
  const double d64 = time_range(64, "elas.ms_640x512_d64", "");
  const double d320 = time_range(320, "elas.ms_640x512_d320", "");
  report.add("elas.ms_d320_over_d64", d320 / d64, "1", "bar <= 1.2");
}

StereoCalibration distorted_rig() {
  StereoCalibration calibration;
  for (RawCamera* camera : {&calibration.left, &calibration.right}) {
    camera->pinhole = {640, 512, 377, 377, 319.5, 255.5};
    camera->distortion = DistortionModel::kRadialTangential;
    camera->coefficients = {-0.28, 0.08, 1e-4, -2e-4, 0.0};
  }
  calibration.T_right_left.translation().x() = -0.26;
  return calibration;
}

/// Smoothed noise moved by a few pixels: for machines without the public data.
PublicPair synthetic_pair() {
  PublicPair pair{"synthetic", cv::Mat1b(512, 640), {}, {}, {}, 128};
  cv::RNG(1).fill(pair.left, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(pair.left, pair.left, {5, 5}, 1.2);
  cv::Mat wide;
  cv::copyMakeBorder(pair.left, wide, 0, 0, 0, 20, cv::BORDER_REFLECT);
  pair.right = wide(cv::Rect(20, 0, 640, 512)).clone();
  return pair;
}

void body(bench::Report& report) {
  cv::setNumThreads(1);
  PublicPair pair = synthetic_pair();
  PublicPair other{"mirrored", pair.right, pair.left, {}, {}, 64};
  if (bench::data_dir().empty()) {
    std::printf("ARPENT_DATA is not set: accuracy is left out, times are those of a synthetic pair\n");
  } else {
    const std::vector<PublicPair> pairs = bench::load_public_pairs(bench::data_dir());
    measure_accuracy(report, pairs);
    pair = bench::cropped(pairs[2], {6, 20, 640, 512}, 128);
    other = pairs[0];
  }
  report.add("elas.deterministic", is_deterministic(pair, other) ? 1 : 0, "1", "bar 1");
  measure_times(report, pair);
  const stereo::Rectifier rectifier(distorted_rig());
  report.add_time(
      "rectify.ms_pair", [&] { (void)rectifier.rectify(pair.left, pair.right); }, 15, "bar <= 0.025");
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "Stereo matching on public pairs", arpent::body);
}
