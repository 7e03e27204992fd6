// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// One exposure for both cameras. The controller looks at the mean of both images and asks for one exposure time and one
// gain, written to both in the same gap: two controllers would pull the images apart, and a stereo matcher compares
// grey values. Exposure grows first, up to the bound that motion blur sets; gain comes after it.
#pragma once

#include <optional>
#include <string>

#include "common/config/fields.h"
#include "drivers/camera/frame_source.h"

namespace arpent::camera {

struct ExposureParams {
  std::string mode = "auto";
  int exposure_us = 3000;
  double gain_db = 0;
  double target_level = 90;
  double dead_band = 0.1;
  int min_exposure_us = 50;
  int max_exposure_us = 6000;
  double max_gain_db = 18;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field(
        "mode", self.mode,
        "auto: follows the light; fixed: exposure_us and gain_db for ever; device: the camera exposes by itself "
        "(v4l2)",
        config::one_of({"auto", "fixed", "device"}));
    visitor.field("exposure_us", self.exposure_us, "exposure time at the start", config::between(1, 1000000));
    visitor.field("gain_db", self.gain_db, "analogue gain at the start", config::between(0.0, 48.0));
    visitor.field("target_level", self.target_level, "mean grey of both images that is wanted, of 255",
                  config::between(10.0, 200.0));
    visitor.field("dead_band", self.dead_band, "share of the target within which nothing changes",
                  config::between(0.0, 0.5));
    visitor.field("min_exposure_us", self.min_exposure_us, "shortest exposure", config::between(1, 1000000));
    visitor.field("max_exposure_us", self.max_exposure_us,
                  "longest exposure: at 1 rad/s and f = 377 px, 6000 us blur 2.3 px", config::between(1, 1000000));
    visitor.field("max_gain_db", self.max_gain_db, "highest gain", config::between(0.0, 48.0));
  }
};

class ExposureController {
 public:
  /// Throws InputError if the bounds contradict each other.
  explicit ExposureController(const ExposureParams& params);

  [[nodiscard]] const ExposureSetting& setting() const { return setting_; }
  /// A new setting, if one is needed. `taken_with`: what this pair was taken with; a pair that was taken before the
  /// last change says nothing new and is passed over, so that the loop cannot swing. `mean_level`: of both images, 0 to
  /// 255.
  [[nodiscard]] std::optional<ExposureSetting> update(const ExposureSetting& taken_with, double mean_level);

 private:
  ExposureParams params_;
  ExposureSetting setting_;
};

}  // namespace arpent::camera
