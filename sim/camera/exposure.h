// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The camera's automatic exposure: from the mean level of the last picture to the exposure and gain of the next.
#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "sim/camera/camera_model.h"

namespace arpent::sim {

struct ExposureParams {
  double target_level = 100;
  double share = 0.6;  ///< of the way to the target in one step, in stops
  double least_s = 0.0001;
  double most_s = 0.008;  ///< beyond it, gain: motion blur stays below a few pixels
  double most_gain = 8;
};

/// Proportional control of the logarithm of the exposure. Both cameras of a pair use one controller's setting.
class AutoExposure {
 public:
  explicit AutoExposure(const ExposureParams& params = {}) : params_(params) {}

  [[nodiscard]] double exposure_s() const { return std::min(amount_s_, params_.most_s); }
  [[nodiscard]] double gain() const { return std::max(1.0, amount_s_ / params_.most_s); }

  /// Every fourth pixel of the picture counts.
  void update(const cv::Mat1b& image) {
    double sum = 0;
    int count = 0;
    for (int v = 0; v < image.rows; v += 2) {
      for (int u = 0; u < image.cols; u += 2, ++count) sum += image(v, u);
    }
    const double level = std::max(1.0, count > 0 ? sum / count : params_.target_level);
    amount_s_ = std::clamp(amount_s_ * std::pow(params_.target_level / level, params_.share), params_.least_s,
                           params_.most_s * params_.most_gain);
  }

 private:
  ExposureParams params_;
  double amount_s_ = kNominalExposureS;  ///< exposure times gain
};

}  // namespace arpent::sim
