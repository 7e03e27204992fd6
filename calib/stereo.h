// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Calibrates one or more cameras that are fixed to each other from views of one board: lenses and places jointly,
// robust first, then least squares on what is no outlier, with the covariance of every parameter (Hartley and Zisserman
// 2004, Ch. 18; thesis App. A.2.3).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/rig_problem.h"
#include "calib/views.h"

namespace arpent::calib {

struct CalibrationParams {
  DistortionModel model = DistortionModel::kRadialTangential;
  bool reject_outliers = true;
  /// Where to start instead of trying focal lengths: lenses and places of the cameras (boards are found anew).
  std::optional<RigEstimate> start;
};

/// A view, or one camera's part of it, that was left out.
struct RejectedView {
  std::string view;
  std::string camera;
  double rms_px = 0;
};

struct Residual {
  Observation observation;  ///< `view` counts BoardViews::views of the input to calibrate()
  Eigen::Vector2d error_px;
};

struct Calibration {
  BoardViews views;  ///< what was used: rejected views and corners are gone
  RigEstimate rig;
  std::vector<Residual> residuals;  ///< of the corners used
  std::vector<RejectedView> rejected_views;
  int rejected_corners = 0;  ///< in views that were used
  double rms_px = 0;         ///< root mean square distance, all corners used
  double sigma_px = 0;       ///< noise per coordinate: squares over degrees of freedom
  /// Parameters as unit_covariance() lists them; empty if the views do not determine them.
  Eigen::MatrixXd covariance;

  [[nodiscard]] Eigen::Index mount_index(std::size_t camera) const {
    return static_cast<Eigen::Index>(kLensParameters * rig.cameras.size() + 6 * (camera - 1));
  }
  /// Standard deviation of one parameter; infinite without covariance.
  [[nodiscard]] double deviation(Eigen::Index parameter) const;
  /// Distance of a camera's centre from the first one's [m], and its standard deviation.
  [[nodiscard]] double baseline_m(std::size_t camera) const;
  [[nodiscard]] double baseline_deviation_m(std::size_t camera) const;
};

/// Throws InputError with a sentence for the user if `input` cannot be used (usable_views).
[[nodiscard]] Calibration calibrate(const BoardViews& input, const CalibrationParams& params = {});

/// Root mean square distance [px] per view and camera; nullopt where nothing was used.
[[nodiscard]] std::vector<std::vector<std::optional<double>>> rms_by_view(const Calibration& calibration);
[[nodiscard]] std::vector<double> rms_by_camera(const Calibration& calibration);

/// How well fixed cameras explain other views: boards' poses are fitted, cameras are not. Root mean square distance.
[[nodiscard]] double rms_of_other_views(const RigEstimate& rig, const BoardViews& views);

/// The pair as the stack knows it: camera 0 is left, 1 right. Only for two cameras or more.
[[nodiscard]] StereoCalibration to_stereo(const RigEstimate& rig);

}  // namespace arpent::calib
