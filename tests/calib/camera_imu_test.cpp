// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/camera_imu.h"

#include <gmock/gmock.h>

#include "common/error.h"
#include "tests/calib/simulated_imu.h"

namespace arpent::calib {
namespace {

using testing::Contains;
using testing::HasSubstr;

std::string fault_of(const CameraImuInput& input) {
  try {
    (void)calibrate_camera_imu(input);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

class EitherCamera : public testing::TestWithParam<CameraMotion> {};

TEST_P(EitherCamera, FindsMountingAndDelayWithinWhatItsCovarianceSays) {
  const ImuTruth truth;
  Eigen::Matrix<double, kCameraImuParameters, 1> squares = Eigen::Matrix<double, kCameraImuParameters, 1>::Zero();
  constexpr int kSeeds = 3;
  for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
    const auto found = calibrate_camera_imu(simulate_imu(truth, GetParam(), Excitation::kAllAxes, seed));
    Eigen::Matrix<double, kCameraImuParameters, 1> error;
    error.head<3>() = so3_log(truth.T_cam_imu.linear().transpose() * found.T_cam_imu.linear());
    error.segment<3>(3) = found.T_cam_imu.translation() - truth.T_cam_imu.translation();
    error[6] = found.time_offset_s - truth.time_offset_s;
    squares += (error.array().square() / found.covariance.diagonal().array() / kSeeds).matrix();
    EXPECT_LT(error.head<3>().norm(), 0.004) << seed;
    EXPECT_LT(error.segment<3>(3).norm(), 0.01) << seed;
    EXPECT_LT(std::abs(error[6]), 0.0005) << seed;
    EXPECT_NEAR(found.reduced_chi2, 1, 0.15) << seed;
    EXPECT_TRUE(unobserved(found).empty()) << testing::PrintToString(unobserved(found));
  }
  // chi2 of 3 over 3: 99.9 % below 5.4; all seven together, of 21: 99.9 % below 2.23, 0.1 % below 0.28.
  for (int k = 0; k < kCameraImuParameters; ++k) EXPECT_LT(squares[k], 5.4) << k;
  EXPECT_LT(squares.mean(), 2.23);
  EXPECT_GT(squares.mean(), 0.28);
}
INSTANTIATE_TEST_SUITE_P(CameraImuCalibration, EitherCamera,
                         testing::Values(CameraMotion::kSteps, CameraMotion::kPoses));

TEST(CameraImuCalibration, OnLevelGroundSaysThatHeightIsNotShown) {
  const ImuTruth truth;
  CameraImuInput input = simulate_imu(truth, CameraMotion::kPoses, Excitation::kLevel, 3);
  input.camera.resize(100);
  const auto found = calibrate_camera_imu(input);
  EXPECT_FALSE(found.place_observed());
  Eigen::Vector3d axis;
  (void)found.worst_deviation(kMountPlace, &axis);
  // The vertical is the unit's z axis.
  EXPECT_GT(std::abs((truth.T_cam_imu.linear() * Eigen::Vector3d::UnitZ()).dot(axis)), 0.99);
  EXPECT_THAT(unobserved(found), Contains(HasSubstr("measure it by hand")));
  EXPECT_TRUE(found.time_offset_observed());
  EXPECT_NEAR(found.time_offset_s, truth.time_offset_s, 0.001);
}

TEST(CameraImuCalibration, SaysInASentenceWhatCannotBeUsed) {
  const CameraImuInput good = simulate_imu({}, CameraMotion::kPoses, Excitation::kAllAxes, 1);
  CameraImuInput input = good;
  for (auto& s : input.imu) s.t_s += 1e6;
  EXPECT_THAT(fault_of(input), HasSubstr("no moment in common"));
  input = good;
  for (auto& s : input.imu) s.t_s += 7;
  EXPECT_THAT(fault_of(input), HasSubstr("do not turn together"));
  input = good;
  input.camera.resize(40);
  EXPECT_THAT(fault_of(input), HasSubstr("too short"));
  input = good;
  for (auto& c : input.camera) c.T_ref_cam = Pose::Identity();
  EXPECT_THAT(fault_of(input), HasSubstr("no turning"));
  input.imu.clear();
  EXPECT_THAT(fault_of(input), HasSubstr("no readings"));
}

}  // namespace
}  // namespace arpent::calib
