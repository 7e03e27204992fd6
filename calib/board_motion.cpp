// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/board_motion.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calib/initial.h"

namespace arpent::calib {
namespace {

constexpr double kLeastSigmaPx = 0.02;

/// Changes of the view's corners with the camera's pose, by differences.
Eigen::MatrixXd jacobian(const std::vector<Observation>& observations, const RigEstimate& view) {
  constexpr double kStep = 1e-6;
  Eigen::MatrixXd J(2 * observations.size(), 6);
  for (int k = 0; k < 6; ++k) {
    RigEstimate more = view, less = view;
    const Vector6d delta = kStep * Vector6d::Unit(k);
    more.T_first_board[0] = retract(view.T_first_board[0].inverse(), delta).inverse();
    less.T_first_board[0] = retract(view.T_first_board[0].inverse(), -delta).inverse();
    const auto a = residuals(observations, more), b = residuals(observations, less);
    for (std::size_t i = 0; i < a.size(); ++i) {
      J.block<2, 1>(static_cast<Eigen::Index>(2 * i), k) = (a[i] - b[i]) / (2 * kStep);
    }
  }
  return J;
}

}  // namespace

std::vector<BoardPose> camera_poses(const BoardViews& views, const RigEstimate& cameras) {
  RigEstimate rig = place_boards_of(views, cameras);
  const auto observations = to_observations(views);
  solve(observations, rig, {.fix_cameras = true, .cauchy_px = 1});
  std::vector<double> errors_px;
  for (const auto& e : residuals(observations, rig)) errors_px.push_back(e.norm());
  const auto middle = errors_px.begin() + static_cast<std::ptrdiff_t>(errors_px.size() / 2);
  std::nth_element(errors_px.begin(), middle, errors_px.end());
  const double sigma_px = std::max(kLeastSigmaPx, *middle / std::sqrt(2 * std::log(2)));
  std::vector<BoardPose> poses;
  std::size_t at = 0;
  for (std::size_t v = 0; v < views.views.size(); ++v) {
    std::vector<Observation> own;
    for (; at < observations.size() && observations[at].view == static_cast<int>(v); ++at) {
      own.push_back(observations[at]);
      own.back().view = 0;
    }
    const RigEstimate view{rig.cameras, rig.T_cam_first, {rig.T_first_board[v]}};
    const Eigen::MatrixXd J = jacobian(own, view);
    const Matrix6d information = J.transpose() * J / (sigma_px * sigma_px);
    poses.push_back({rig.T_first_board[v].inverse(), information.inverse()});
  }
  return poses;
}

}  // namespace arpent::calib
