// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/drive.h"

#include <gmock/gmock.h>

#include "common/error.h"
#include "tests/calib/simulated_drive.h"

namespace arpent::calib {
namespace {

using testing::Contains;
using testing::HasSubstr;

std::string fault_of(const DriveInput& input) {
  try {
    (void)calibrate_drive(input);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

class EitherMotion : public testing::TestWithParam<CameraMotion> {};

TEST_P(EitherMotion, FindsWheelsClockAndMountingWithinWhatItsCovarianceSays) {
  const DriveTruth truth;
  Eigen::Matrix<double, kDriveParameters, 1> squares = Eigen::Matrix<double, kDriveParameters, 1>::Zero();
  constexpr int kSeeds = 10;
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    const DriveCalibration found = calibrate_drive(simulate_drive(truth, GetParam(), seed));
    const auto error = error_of(found, truth);
    EXPECT_LT(std::abs(error[kLeftScale]), 0.012) << seed;
    EXPECT_LT(std::abs(error[kTimeOffset]), 0.004) << seed;
    squares += (error.array().square() / found.covariance.diagonal().array() / kSeeds).matrix();
  }
  for (int k = 0; k < kStepScale; ++k) {
    EXPECT_LT(squares[k], 3) << "chi2 of 10 over 10: 99.9 % below 2.96; parameter " << k;
    EXPECT_GT(squares[k], 0.05) << k;
  }
}
INSTANTIATE_TEST_SUITE_P(DriveCalibration, EitherMotion, testing::Values(CameraMotion::kSteps, CameraMotion::kPoses));

TEST(DriveCalibration, SeesTiltOnlyByPosesAndHeightNever) {
  const DriveTruth truth;
  const auto poses = calibrate_drive(simulate_drive(truth, CameraMotion::kPoses, 1));
  EXPECT_TRUE(poses.tilt_observed);
  EXPECT_NEAR(-std::asin(poses.T_body_filed.linear()(2, 0)), truth.mount_pitch_rad, 5 * poses.tilt_deviation_rad);
  EXPECT_EQ(poses.T_body_filed.translation().z(), 0);
  EXPECT_FALSE(calibrate_drive(simulate_drive(truth, CameraMotion::kSteps, 1)).tilt_observed);
}

TEST(DriveCalibration, OfOneCircleSaysWhatItDoesNotShowInsteadOfInventingIt) {
  const DriveTruth truth;
  DriveInput input = simulate_drive(truth, CameraMotion::kSteps, 2, true);
  input.camera.erase(input.camera.begin(), input.camera.begin() + 25);  // the start shows the clocks' offset
  const auto found = calibrate_drive(input);
  EXPECT_FALSE(found.observed(kTimeOffset));
  EXPECT_FALSE(found.observed(kMountYaw));
  EXPECT_THAT(unobserved(found), Contains(HasSubstr("do not drive in one circle")));
  EXPECT_THAT(unobserved(found), Contains(HasSubstr("height")));
  // A turn and a speed are all that a circle shows, of the two scales, the track and the three of the mounting.
  for (const auto k : {kLeftScale, kRightScale, kTrack, kMountX, kMountY}) EXPECT_FALSE(found.observed(k)) << k;
  const auto driven = calibrate_drive(simulate_drive(truth, CameraMotion::kSteps, 2));
  for (int k = 0; k < kDriveParameters; ++k) EXPECT_TRUE(driven.observed(static_cast<DriveParameter>(k))) << k;
  EXPECT_EQ(unobserved(driven).size(), 2U) << "tilt and height";
}

TEST(DriveCalibration, TheOdometrysScaleIsInTheDeviationsOfTheWheels) {
  DriveInput input = simulate_drive({}, CameraMotion::kSteps, 4);
  input.step_scale_deviation = 1e-6;
  const auto trusted = calibrate_drive(input);
  input.step_scale_deviation = 0.005;
  const auto doubted = calibrate_drive(input);
  EXPECT_LT(trusted.deviation(kLeftScale), 0.002);
  EXPECT_NEAR(doubted.deviation(kLeftScale), std::hypot(trusted.deviation(kLeftScale), 0.005), 5e-4);
}

TEST(DriveCalibration, SaysInASentenceWhatCannotBeUsed) {
  const DriveInput good = simulate_drive({}, CameraMotion::kPoses, 3);
  DriveInput input = good;
  for (auto& w : input.wheels) std::swap(w.left_m, w.right_m);
  EXPECT_THAT(fault_of(input), HasSubstr("swapped"));
  input = good;
  for (auto& w : input.wheels) w.t_s += 3;
  EXPECT_THAT(fault_of(input), HasSubstr("clocks apart"));
  input = good;
  for (auto& w : input.wheels) w.t_s += 1e6;
  EXPECT_THAT(fault_of(input), HasSubstr("no moment in common"));
  input = good;
  input.camera.resize(12);
  EXPECT_THAT(fault_of(input), HasSubstr("too short"));
  input = good;
  for (auto& c : input.camera) c.T_ref_body = Pose::Identity();
  EXPECT_THAT(fault_of(input), HasSubstr("no motion"));
  input = good;
  for (auto& w : input.wheels) w.left_m = -w.left_m;
  EXPECT_NE(fault_of(input), "no fault");
}

}  // namespace
}  // namespace arpent::calib
