// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/calib/simulated_views.h"

#include <cmath>
#include <random>

#include "sim/camera/lens.h"

namespace arpent::calib {

RigEstimate simulated_rig(DistortionModel model) {
  RawCamera left, right;
  left.pinhole = {1280, 1024, 760, 762, 645, 505};
  right.pinhole = {1280, 1024, 751, 750, 630, 520};
  left.distortion = right.distortion = model;
  if (model == DistortionModel::kRadialTangential) {
    left.coefficients = {-0.28, 0.08, 0.0006, -0.0004, 0};
    right.coefficients = {-0.27, 0.07, -0.0003, 0.0005, 0};
  } else if (model == DistortionModel::kEquidistant) {
    left.coefficients = {-0.02, 0.004, -0.003, 0.0006, 0};
    right.coefficients = {-0.015, 0.002, -0.001, 0.0003, 0};
  }
  Pose T_right_left = Pose::Identity();
  T_right_left.linear() = so3_exp({0.006, -0.012, 0.004});
  T_right_left.translation() = Eigen::Vector3d(-0.26, 0.0015, -0.002);
  return {{left, right}, {Pose::Identity(), T_right_left}, {}};
}

std::vector<Pose> simulated_boards(const SimulationOptions& options, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Target target;
  const Eigen::Vector2d middle_m = 0.5 * target.size_m();
  std::vector<Pose> boards;
  for (int v = 0; v < options.views; ++v) {
    const double z_m = 0.85 + 0.35 * uniform(generator);
    Pose T_cam_board = Pose::Identity();
    // The board's y is up, the camera's down.
    T_cam_board.linear() = so3_exp({options.tilt_rad * uniform(generator), options.tilt_rad * uniform(generator),
                                    0.5 * options.tilt_rad * uniform(generator)}) *
                           so3_exp({M_PI, 0, 0});
    const Eigen::Vector3d centre_m(options.spread * 0.8 * z_m * uniform(generator) + 0.13,
                                   options.spread * 0.65 * z_m * uniform(generator), z_m);
    T_cam_board.translation() = centre_m - T_cam_board.linear() * Eigen::Vector3d(middle_m.x(), middle_m.y(), 0);
    boards.push_back(T_cam_board);
  }
  return boards;
}

BoardViews simulate_views(const RigEstimate& rig, const SimulationOptions& options, std::uint32_t seed) {
  std::mt19937 generator(seed + 1000000);
  std::normal_distribution<double> noise(0, options.noise_px);
  BoardViews views{Target{}, {{"cam0", 1280, 1024}, {"cam1", 1280, 1024}}, {}};
  for (const Pose& T_left_board : simulated_boards(options, seed)) {
    View view{"view" + std::to_string(views.views.size()), {{}, {}}};
    for (std::size_t c = 0; c < 2; ++c) {
      for (int i = 0; i < views.target.corner_count(); ++i) {
        const Eigen::Vector2d b = views.target.corner_m(i);
        const Eigen::Vector3d p = rig.T_cam_first[c] * T_left_board * Eigen::Vector3d(b.x(), b.y(), 0);
        const Eigen::Vector2d error(noise(generator), noise(generator));
        if (p.z() < 0.2) continue;
        const Eigen::Vector2d plane = sim::distort(rig.cameras[c], p.head<2>() / p.z());
        const PinholeCamera& k = rig.cameras[c].pinhole;
        const Eigen::Vector2d px(k.fx_px * plane.x() + k.cx_px, k.fy_px * plane.y() + k.cy_px);
        const bool inside = px.x() > 3 && px.y() > 3 && px.x() < k.width_px - 4 && px.y() < k.height_px - 4;
        // A radial polynomial folds back far outside the image.
        if (inside && (p.head<2>() / p.z()).norm() < 1.2) view.cameras[c].push_back({i, px + error});
      }
    }
    views.views.push_back(view);
  }
  if (options.left_only) {
    views.cameras.resize(1);
    for (View& view : views.views) view.cameras.resize(1);
  }
  return views;
}

Eigen::VectorXd parameter_vector(const RigEstimate& rig) {
  std::vector<double> numbers;
  for (const RawCamera& camera : rig.cameras) {
    for (const double x : to_parameters(camera)) numbers.push_back(x);
  }
  for (std::size_t c = 1; c < rig.cameras.size(); ++c) {
    const Eigen::Vector3d t = rig.T_cam_first[c].translation(), w = so3_log(rig.T_cam_first[c].linear());
    for (const double x : {t.x(), t.y(), t.z(), w.x(), w.y(), w.z()}) numbers.push_back(x);
  }
  return Eigen::Map<Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

}  // namespace arpent::calib
