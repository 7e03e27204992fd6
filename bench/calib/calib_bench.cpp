// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `calib`: calibration against OpenCV's on its own chessboard set, boards found in public pictures, errors and
// honesty against simulated rigs, and what forty pairs cost.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>

#include "bench/calib/rows.h"
#include "bench/harness.h"
#include "calib/stereo.h"
#include "perception/tags/detector.h"
#include "tests/calib/simulated_views.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;
using calib::BoardViews;
using calib::Calibration;

constexpr int kSeeds = 20;
constexpr int kHonestySeeds = 200;  // the mean square of 20 normalised errors alone scatters from 0.5 to 1.7

void measure_simulated(bench::Report& report) {
  const calib::RigEstimate truth = calib::simulated_rig(DistortionModel::kRadialTangential);
  const Eigen::VectorXd p_true = calib::parameter_vector(truth);
  std::vector<double> focal_percent, centre_px, baseline_percent;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(p_true.size());
  for (int seed = 0; seed < kHonestySeeds; ++seed) {
    const BoardViews views = calib::simulate_views(truth, {}, static_cast<std::uint32_t>(seed));
    calib::CalibrationParams params;
    // Beyond the seeds whose errors are reported, the search for a start is spared: its result is the same minimum.
    if (seed >= kSeeds) params.start = truth;
    const Calibration found = calib::calibrate(views, params);
    const Eigen::VectorXd error = calib::parameter_vector(found.rig) - p_true;
    squares += (error.array().square() / found.covariance.diagonal().array() / kHonestySeeds).matrix();
    if (seed >= kSeeds) continue;
    for (const Eigen::Index c : {0, calib::kLensParameters}) {
      for (const Eigen::Index k : {0, 1}) focal_percent.push_back(100 * std::abs(error[c + k]) / p_true[c + k]);
      centre_px.push_back(error.segment<2>(c + 2).norm());
    }
    const double true_m = truth.T_cam_first[1].translation().norm();
    baseline_percent.push_back(100 * std::abs(found.baseline_m(1) - true_m) / true_m);
  }
  report.add("calib.focal_error_percent", bench::median(focal_percent), "%", "bar <= 0.05; 0.1 px noise, 20 seeds");
  report.add("calib.centre_error_px", bench::median(centre_px), "px", "bar <= 0.3");
  report.add("calib.baseline_error_percent", bench::median(baseline_percent), "%", "bar <= 0.1");
  report.add("calib.normalised_error_min", squares.minCoeff(), "1", "bar >= 0.7; 22 parameters, 200 seeds");
  report.add("calib.normalised_error_max", squares.maxCoeff(), "1", "bar <= 1.4");
}

void body(bench::Report& report) {
  cv::setNumThreads(1);
  if (bench::data_dir().empty()) {
    std::printf("ARPENT_DATA is not set: rows of the public sets are left out\n");
  } else {
    bench::add_chessboard_rows(report, fs::path(bench::data_dir()) / "stereo/chessboard");
    bench::add_apriltag_rows(report, fs::path(bench::data_dir()) / "stereo/apriltag");
  }
  measure_simulated(report);
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "Calibration: errors, honesty, boards found, cost", arpent::body);
}
