// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/exposure_controller.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace arpent::camera {
namespace {

/// A saturated image hides how much too bright it is, a black one how much too dark: larger steps are guesses.
constexpr double kLargestStep = 4;
/// What devices round an exposure or a gain to, at most.
constexpr double kRoundedExposure = 0.02;
constexpr double kRoundedGainDb = 0.5;

bool same(const ExposureSetting& a, const ExposureSetting& b) {
  return std::abs(a.exposure_us - b.exposure_us) <= 1 + kRoundedExposure * b.exposure_us &&
         std::abs(a.gain_db - b.gain_db) <= kRoundedGainDb;
}

}  // namespace

ExposureController::ExposureController(const ExposureParams& params)
    : params_(params), setting_{params.exposure_us, params.gain_db} {
  if (params.min_exposure_us > params.max_exposure_us) {
    throw InputError("exposure.min_exposure_us must be <= exposure.max_exposure_us");
  }
}

std::optional<ExposureSetting> ExposureController::update(const ExposureSetting& taken_with, double mean_level) {
  if (params_.mode != "auto" || !same(taken_with, setting_)) return std::nullopt;
  if (std::abs(mean_level - params_.target_level) <= params_.dead_band * params_.target_level) return std::nullopt;
  const double step = std::clamp(params_.target_level / std::max(mean_level, 1.0), 1 / kLargestStep, kLargestStep);
  const double light_us = step * setting_.exposure_us * std::pow(10.0, setting_.gain_db / 20);
  ExposureSetting wanted;
  wanted.exposure_us = static_cast<int>(
      std::lround(std::clamp(light_us, double(params_.min_exposure_us), double(params_.max_exposure_us))));
  wanted.gain_db = std::clamp(20 * std::log10(light_us / wanted.exposure_us), 0.0, params_.max_gain_db);
  if (same(wanted, setting_)) return std::nullopt;
  setting_ = wanted;
  return wanted;
}

}  // namespace arpent::camera
