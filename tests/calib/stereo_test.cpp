// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/stereo.h"

#include <gmock/gmock.h>

#include <random>

#include "calib/initial.h"
#include "calib/quality.h"
#include "common/error.h"
#include "tests/calib/simulated_views.h"

namespace arpent::calib {
namespace {

using testing::Contains;
using testing::HasSubstr;

std::string fault_of(const BoardViews& views) {
  try {
    (void)calibrate(views);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

SimulationOptions few_views(int views) {
  SimulationOptions options;
  options.views = views;
  return options;
}

class EitherLens : public testing::TestWithParam<DistortionModel> {};

TEST_P(EitherLens, IsFoundWithinWhatItsCovarianceSays) {
  const RigEstimate truth = simulated_rig(GetParam());
  SimulationOptions options = few_views(20);
  options.model = GetParam();
  CalibrationParams params;
  params.model = GetParam();
  const Calibration found = calibrate(simulate_views(truth, options, 1), params);
  EXPECT_NEAR(found.sigma_px, options.noise_px, 0.003);
  EXPECT_TRUE(found.rejected_views.empty());
  const Eigen::VectorXd error = parameter_vector(found.rig) - parameter_vector(truth);
  ASSERT_EQ(found.covariance.rows(), error.size());
  for (Eigen::Index i = 0; i < error.size(); ++i) EXPECT_LT(std::abs(error[i]), 4 * found.deviation(i)) << i;
  // chi2 of 22: 99.9 % below 48.3, 0.1 % below 6.0
  const double chi2 = error.dot(found.covariance.ldlt().solve(error));
  EXPECT_LT(chi2, 48.3);
  EXPECT_GT(chi2, 6.0);
  EXPECT_EQ(assess(found).grade, Grade::kGood) << testing::PrintToString(assess(found).advice);
}
INSTANTIATE_TEST_SUITE_P(Calibration, EitherLens,
                         testing::Values(DistortionModel::kRadialTangential, DistortionModel::kEquidistant));

TEST(Calibration, WithoutNoiseIsExact) {
  const RigEstimate truth = simulated_rig(DistortionModel::kRadialTangential);
  SimulationOptions options = few_views(8);
  options.noise_px = 0;
  const Calibration found = calibrate(simulate_views(truth, options, 2));
  EXPECT_LT((parameter_vector(found.rig) - parameter_vector(truth)).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(Calibration, OfOneCameraWorks) {
  const RigEstimate truth = simulated_rig(DistortionModel::kRadialTangential);
  SimulationOptions options = few_views(15);
  options.left_only = true;
  const Calibration found = calibrate(simulate_views(truth, options, 3));
  EXPECT_NEAR(found.rig.cameras[0].pinhole.fx_px, truth.cameras[0].pinhole.fx_px, 0.5);
}

TEST(Calibration, OfNearlyStaticViewsFindsTheFocalLengthByThePair) {
  const RigEstimate truth = simulated_rig(DistortionModel::kRadialTangential);
  SimulationOptions options = few_views(12);
  options.tilt_rad = 0.04;
  options.spread = 0.1;
  for (std::uint32_t seed = 0; seed < 2; ++seed) {
    const Calibration found = calibrate(simulate_views(truth, options, seed));
    EXPECT_NEAR(found.rig.cameras[0].pinhole.fx_px / truth.cameras[0].pinhole.fx_px, 1, 0.05) << seed;
    EXPECT_NEAR(found.baseline_m(1), 0.26, 0.01) << seed;
  }
}

TEST(Calibration, LeavesOutASpoiltViewAndNamesIt) {
  const RigEstimate truth = simulated_rig(DistortionModel::kRadialTangential);
  BoardViews views = simulate_views(truth, few_views(15), 4);
  std::mt19937 generator(1);
  std::normal_distribution<double> blur(0, 3);
  for (Corner& corner : views.views[7].cameras[1]) corner.px += Eigen::Vector2d(blur(generator), blur(generator));
  views.views[3].cameras[0][5].px.x() += 8;
  const Calibration found = calibrate(views);
  ASSERT_EQ(found.rejected_views.size(), 1U);
  EXPECT_EQ(found.rejected_views[0].view, "view7");
  EXPECT_EQ(found.rejected_views[0].camera, "cam1");
  EXPECT_EQ(found.rejected_corners, 1);
  EXPECT_NEAR(found.sigma_px, 0.1, 0.005);
}

TEST(Calibration, OfSwappedCamerasIsCalledBad) {
  BoardViews views = simulate_views(simulated_rig(DistortionModel::kRadialTangential), few_views(10), 5);
  for (View& view : views.views) std::swap(view.cameras[0], view.cameras[1]);
  const Quality quality = assess(calibrate(views));
  EXPECT_EQ(quality.grade, Grade::kBad);
  EXPECT_THAT(quality.advice, Contains(HasSubstr("swapped")));
}

TEST(Calibration, OfABoardThatWasNeverTiltedIsCalledBad) {
  SimulationOptions options = few_views(12);
  options.tilt_rad = 0.02;
  const Quality quality =
      assess(calibrate(simulate_views(simulated_rig(DistortionModel::kRadialTangential), options, 6)));
  EXPECT_EQ(quality.grade, Grade::kBad);
  EXPECT_THAT(quality.advice, Contains(HasSubstr("no parallax")));
}

TEST(Calibration, OfPairsOfDifferentMomentsSaysSo) {
  BoardViews views = simulate_views(simulated_rig(DistortionModel::kRadialTangential), few_views(10), 7);
  // The right camera lags: the board moved by 4 px and a little more each time.
  for (std::size_t v = 0; v < views.views.size(); ++v) {
    const double shift_px = v % 2 == 0 ? 4 : -4;
    for (Corner& corner : views.views[v].cameras[1]) corner.px.y() += shift_px;
  }
  CalibrationParams params;
  params.reject_outliers = false;
  const Quality quality = assess(calibrate(views, params));
  EXPECT_EQ(quality.grade, Grade::kBad);
  EXPECT_THAT(quality.advice, Contains(HasSubstr("same moment")));
}

TEST(Calibration, SaysInASentenceWhatCannotBeUsed) {
  const RigEstimate truth = simulated_rig(DistortionModel::kRadialTangential);
  EXPECT_THAT(fault_of(simulate_views(truth, few_views(3), 8)), HasSubstr("too few views"));
  BoardViews spaced = simulate_views(truth, few_views(8), 9);
  spaced.target.spacing_ratio = 0.0264;  // metres instead of the ratio
  EXPECT_THAT(fault_of(spaced), HasSubstr("wrong spacing"));
  BoardViews apart = simulate_views(truth, few_views(10), 10);
  for (std::size_t v = 0; v < 10; ++v) apart.views[v].cameras[v % 2].clear();
  EXPECT_THAT(fault_of(apart), HasSubstr("never sees the board together"));
}

TEST(CalibQuality, UncertaintyOfAProjectionIsWhatSamplesOfTheLensShow) {
  const RawCamera camera = simulated_rig(DistortionModel::kRadialTangential).cameras[0];
  // Only the centre is uncertain, by 1 px: nearly a turn of the camera, which does not count.
  Eigen::MatrixXd centre = Eigen::MatrixXd::Zero(8, 8);
  centre(2, 2) = centre(3, 3) = 1;
  double worst = 0;
  cv::minMaxLoc(projection_uncertainty(camera, centre), nullptr, &worst);
  EXPECT_LT(worst, 0.8);
  // Only the focal lengths, by 1 %: off by 1 % of the distance from the centre. Per coordinate, sqrt(1/2) of it.
  Eigen::MatrixXd focal = Eigen::MatrixXd::Zero(8, 8);
  focal(0, 0) = focal(0, 1) = focal(1, 0) = focal(1, 1) = 7.6 * 7.6;
  const cv::Mat1f map = projection_uncertainty(camera, focal);
  EXPECT_NEAR(map(0, 0), 0.01 * std::hypot(645 - 64, 505 - 64) / std::sqrt(2), 0.6);
}

}  // namespace
}  // namespace arpent::calib
