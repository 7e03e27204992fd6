// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `vo`: the odometry on the public KITTI clip ($ARPENT_DATA/vo), forwards and backwards, and at rest under fresh
// noise; and a creep through the rendered arena.
#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "bench/harness.h"
#include "perception/odometry/odometry.h"
#include "sim/sequence.h"
#include "tools/datasets/dataset.h"
#include "tools/evaluation/trajectory.h"

namespace arpent {
namespace {

constexpr int kSeeds = 20;

struct Clip {
  RectifiedStereo stereo;
  std::vector<std::pair<cv::Mat1b, cv::Mat1b>> pairs;
  evaluation::Trajectory truth;  ///< T_cam0first_cam0
};

Clip load_clip() {
  const tools::Dataset dataset = tools::read_kitti(bench::data_dir() + "/vo/kitti06_0000-0039");
  Clip clip;
  clip.stereo = {dataset.calibration.left.pinhole, -dataset.calibration.T_right_left.translation().x()};
  const Pose T_body_cam = dataset.calibration.T_body_left;
  for (std::size_t i = 0; i < dataset.frames.size(); ++i) {
    clip.pairs.emplace_back(cv::imread(dataset.frames[i].left.string(), cv::IMREAD_GRAYSCALE),
                            cv::imread(dataset.frames[i].right.string(), cv::IMREAD_GRAYSCALE));
    clip.truth.push_back({dataset.truth[i].stamp, T_body_cam.inverse() * dataset.truth[i].T_world_body * T_body_cam});
  }
  return clip;
}

Clip backwards(Clip clip) {
  std::reverse(clip.pairs.begin(), clip.pairs.end());
  evaluation::Trajectory truth;
  for (std::size_t i = 0; i < clip.truth.size(); ++i) {
    truth.push_back({clip.truth[i].stamp, clip.truth[clip.truth.size() - 1 - i].T_ref_body});
  }
  clip.truth = truth;
  return clip;
}

evaluation::Trajectory run(const Clip& clip, int seed, std::vector<double>* times_ms = nullptr) {
  odometry::OdometryParams params;
  params.seed = seed;
  odometry::StereoOdometry odometry(clip.stereo, params);
  evaluation::Trajectory trajectory;
  for (std::size_t i = 0; i < clip.pairs.size(); ++i) {
    odometry::Estimate estimate;
    const double ms = bench::cpu_ms(
        [&] { estimate = odometry.track(clip.truth[i].stamp, clip.pairs[i].first, clip.pairs[i].second); });
    if (times_ms != nullptr) times_ms->push_back(ms);
    trajectory.push_back({clip.truth[i].stamp, estimate.T_odom_cam});
  }
  return trajectory;
}

void measure_drift(bench::Report& report, const Clip& clip, const std::string& suffix, const std::string& t_bar,
                   const std::string& ate_bar) {
  std::vector<double> t_rel, ate;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const auto errors =
        evaluation::evaluate(clip.truth, run(clip, seed), evaluation::Alignment::kSe3, {10, 20, 30, 40});
    t_rel.push_back(errors.segments.t_rel_percent);
    ate.push_back(errors.ate_m.rmse);
  }
  report.add("vo.t_rel_percent" + suffix, bench::median(t_rel), "%", t_bar);
  report.add("vo.ate_m" + suffix, bench::median(ate), "m", ate_bar);
}

double standstill_mm(const Clip& clip) {
  odometry::StereoOdometry odometry(clip.stereo, {});
  cv::RNG rng(1);
  odometry::Estimate estimate;
  for (int i = 0; i < 100; ++i) {
    cv::Mat1b noisy[2];
    for (int k = 0; k < 2; ++k) {
      const cv::Mat1b& image = k == 0 ? clip.pairs[0].first : clip.pairs[0].second;
      cv::Mat1s noise(image.size());
      rng.fill(noise, cv::RNG::NORMAL, 0, 2);
      cv::add(image, noise, noisy[k], cv::noArray(), CV_8U);
    }
    estimate = odometry.track(Time(std::chrono::milliseconds(100 * i)), noisy[0], noisy[1]);
  }
  return 1e3 * estimate.T_odom_cam.translation().norm();
}

/// A creep of 2 mm per pair through the rendered arena: error of the last position.
double creep_error_mm() {
  constexpr int kPairs = 100;
  constexpr double kStepM = 0.002;
  const RectifiedStereo stereo{{640, 512, 377, 377, 319.5, 255.5}, 0.26};
  const sim::Scene scene = sim::make_test_arena();
  Pose T_body_cam(R_body_from_camera_axes());
  T_body_cam.translation() = Eigen::Vector3d(0.2, 0.13, 0.4);
  odometry::StereoOdometry odometry(stereo, {});
  odometry::Estimate estimate;
  for (int i = 0; i < kPairs; ++i) {
    sim::DrivePose pose;
    pose.T_world_body.translation() = Eigen::Vector3d(1.0 + kStepM * i, 2.4, 0);
    const auto pair = sim::render_pair(scene, stereo, T_body_cam, pose, static_cast<std::uint64_t>(i));
    estimate = odometry.track(Time(std::chrono::milliseconds(100 * i)), pair.left, pair.right);
  }
  // Straight ahead is the camera's z.
  return 1e3 * (estimate.T_odom_cam.translation() - Eigen::Vector3d(0, 0, kStepM * (kPairs - 1))).norm();
}

void body(bench::Report& report) {
  cv::setNumThreads(1);
  report.add("vo.creep_error_mm", creep_error_mm(), "mm", "bar <= 10");
  if (bench::data_dir().empty()) {
    std::printf("ARPENT_DATA is not set: the KITTI figures are left out\n");
    return;
  }
  const Clip clip = load_clip();
  measure_drift(report, clip, "", "bar <= 0.85 (libviso2 0.93, ORB-SLAM2 0.66-0.68)",
                "bar <= 0.08 (0.094, 0.035-0.046)");
  measure_drift(report, backwards(clip), "_backwards", "", "");
  std::vector<double> times_ms, reference_ms;
  for (int i = 0; i < 5; ++i) {
    reference_ms.push_back(bench::time_reference_once());
    run(clip, 1, &times_ms);
  }
  double mean = 0;
  for (const double t : times_ms) mean += t / static_cast<double>(times_ms.size());
  report.add("vo.ms_per_pair", mean, "ms");
  report.add("vo.ms_per_pair_over_ref", mean / bench::median(reference_ms), "1", "bar <= 0.2");
  report.add("vo.standstill_mm", standstill_mm(clip), "mm", "bar <= 5");
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "Visual odometry on the public KITTI clip", arpent::body);
}
