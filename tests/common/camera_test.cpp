// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace arpent {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

StereoCalibration sound() {
  StereoCalibration calibration;
  calibration.left.pinhole = {640, 512, 377, 377, 319.5, 255.5};
  calibration.right = calibration.left;
  calibration.T_right_left.translation().x() = -0.26;
  return calibration;
}

TEST(Camera, UnprojectInvertsProject) {
  const PinholeCamera camera{640, 512, 377, 380, 319.5, 255.5};
  const Eigen::Vector3d p = camera.unproject(100.25, 400.5, 3.5);
  EXPECT_DOUBLE_EQ(p.z(), 3.5);
  EXPECT_NEAR(camera.project(p).x(), 100.25, 1e-12);
  EXPECT_NEAR(camera.project(p).y(), 400.5, 1e-12);
}

TEST(Camera, ASoundCalibrationHasNoFaults) {
  EXPECT_THAT(find_faults(sound()), IsEmpty());
}

TEST(Camera, NaNIsAFault) {
  auto calibration = sound();
  calibration.left.pinhole.fx_px = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(find_faults(calibration), ElementsAre(HasSubstr("finite")));
  calibration = sound();
  calibration.right.coefficients[2] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(find_faults(calibration), ElementsAre(HasSubstr("finite")));
}

TEST(Camera, ANegativeFocalLengthIsAFault) {
  auto calibration = sound();
  calibration.right.pinhole.fy_px = -377;
  EXPECT_THAT(find_faults(calibration), ElementsAre(HasSubstr("right camera: focal length")));
}

TEST(Camera, ASwappedBaselineIsAFaultThatSaysSo) {
  auto calibration = sound();
  calibration.T_right_left.translation().x() = 0.26;
  EXPECT_THAT(find_faults(calibration), ElementsAre(HasSubstr("swapped")));
}

TEST(Camera, ImagesOfDifferentSizesAreAFault) {
  auto calibration = sound();
  calibration.right.pinhole.width_px = 600;
  EXPECT_THAT(find_faults(calibration), ElementsAre(HasSubstr("same size")));
}

TEST(Camera, AStretchedRotationIsAFault) {
  auto calibration = sound();
  calibration.T_right_left.linear() *= 1.1;
  EXPECT_THAT(find_faults(calibration), ElementsAre(HasSubstr("rigid")));
}

}  // namespace
}  // namespace arpent
