// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The exposure controller in front of a camera that is a formula: grey = light * exposure * gain, saturated at 255.
#include "drivers/camera/exposure_controller.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace arpent::camera {
namespace {

double level(double light_per_us, const ExposureSetting& s) {
  return std::min(255.0, light_per_us * s.exposure_us * std::pow(10.0, s.gain_db / 20));
}

/// Pairs until the level lies within the dead band, with `delay` pairs from a setting to its first image; -1: never.
int pairs_until_settled(ExposureController& controller, double light_per_us, int delay = 2) {
  std::vector<ExposureSetting> in_force(static_cast<std::size_t>(delay), controller.setting());
  for (int pair = 0; pair < 100; ++pair) {
    const ExposureSetting taken = in_force.front();
    in_force.erase(in_force.begin());
    const double grey = level(light_per_us, taken);
    if (taken == controller.setting() && std::abs(grey - 90) <= 9.01) return pair;
    (void)controller.update(taken, grey);
    in_force.push_back(controller.setting());
  }
  return -1;
}

TEST(CameraExposure, SettlesFromSaturationAndFromTheDarkWithinTwoSecondsAtFiveHertz) {
  for (const double light : {0.5, 0.2, 0.03, 0.003}) {
    ExposureController controller{ExposureParams{}};
    const int pairs = pairs_until_settled(controller, light);
    EXPECT_GE(pairs, 0) << light;
    EXPECT_LE(pairs, 12) << light;
  }
}

TEST(CameraExposure, GainComesOnlyAfterTheLongestExposure) {
  ExposureController controller{ExposureParams{}};
  ASSERT_GE(pairs_until_settled(controller, 0.02), 0);
  EXPECT_LT(controller.setting().exposure_us, 6000);
  EXPECT_EQ(controller.setting().gain_db, 0);
  ASSERT_GE(pairs_until_settled(controller, 0.004), 0);
  EXPECT_EQ(controller.setting().exposure_us, 6000);
  EXPECT_GT(controller.setting().gain_db, 0);
}

TEST(CameraExposure, StaysWithinItsBoundsWhereNoSettingIsEnough) {
  ExposureController controller{ExposureParams{}};
  for (int i = 0; i < 20; ++i) (void)controller.update(controller.setting(), 1);
  EXPECT_EQ(controller.setting().exposure_us, 6000);
  EXPECT_EQ(controller.setting().gain_db, 18);
  EXPECT_FALSE(controller.update(controller.setting(), 1)) << "nothing is written again and again";
  for (int i = 0; i < 20; ++i) (void)controller.update(controller.setting(), 255);
  EXPECT_EQ(controller.setting().exposure_us, 50);
  EXPECT_EQ(controller.setting().gain_db, 0);
}

TEST(CameraExposure, APairTakenBeforeTheLastChangeSaysNothing) {
  ExposureController controller{ExposureParams{}};
  const ExposureSetting before = controller.setting();
  ASSERT_TRUE(controller.update(before, 30));
  EXPECT_FALSE(controller.update(before, 30));
}

TEST(CameraExposure, ADeviceThatRoundsIsStillRecognised) {
  ExposureController controller{ExposureParams{}};
  EXPECT_TRUE(controller.update({controller.setting().exposure_us - 20, 0.1}, 30));
}

TEST(CameraExposure, FixedMeansFixedAndContradictoryBoundsAreRefused) {
  ExposureParams params;
  params.mode = "fixed";
  ExposureController controller(params);
  EXPECT_FALSE(controller.update(controller.setting(), 1));
  params.min_exposure_us = 9000;
  EXPECT_THROW(ExposureController{params}, InputError);
}

}  // namespace
}  // namespace arpent::camera
