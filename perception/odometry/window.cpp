// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/odometry/window.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace arpent::odometry {
namespace {

constexpr int kMaxIterations = 8;
constexpr double kMinDepthM = 0.05;
constexpr double kLossWidth = 2.5;

using Matrix36d = Eigen::Matrix<double, 3, 6>;

/// Cauchy loss of a squared whitened residual, and its weight.
double loss(double chi2) {
  return kLossWidth * kLossWidth * std::log1p(chi2 / (kLossWidth * kLossWidth));
}
double weight_of(double chi2) {
  return 1.0 / (1.0 + chi2 / (kLossWidth * kLossWidth));
}

Vector3d residual(const RectifiedStereo& stereo, const Observation& o, const Vector3d& p_cam, double sigma_px) {
  Vector3d r = (project(stereo, p_cam) - o.z_px) / sigma_px;
  if (!o.has_right) r.z() = 0;
  return r;
}

double total_loss(const RectifiedStereo& stereo, double sigma_px, const std::vector<Pose>& poses,
                  const std::vector<WindowPoint>& points) {
  double sum = 0;
  for (const WindowPoint& point : points) {
    for (const Observation& o : point.observations) {
      const Vector3d p = poses[static_cast<std::size_t>(o.keyframe)].inverse() * point.p_odom_m;
      sum += p.z() < kMinDepthM ? loss(1e4) : loss(residual(stereo, o, p, sigma_px).squaredNorm());
    }
  }
  return sum;
}

/// The normal equations, with points eliminated.
class Problem {
 public:
  Problem(const RectifiedStereo& stereo, double sigma_px, int fixed, const std::vector<Pose>& poses,
          const std::vector<WindowPoint>& points, double lambda)
      : fixed_(fixed), free_(static_cast<int>(poses.size()) - fixed), H_(6 * free_, 6 * free_), g_(6 * free_) {
    H_.setZero();
    g_.setZero();
    eliminated_.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) add(stereo, sigma_px, poses, points[i], lambda, eliminated_[i]);
    for (int i = 0; i < 6 * free_; ++i) H_(i, i) += lambda * H_(i, i) + 1e-9;
  }

  /// The steps of the free poses, stacked.
  [[nodiscard]] Eigen::VectorXd solve() const { return H_.ldlt().solve(-g_); }

  /// The step of point `i` that belongs to the poses' step.
  [[nodiscard]] Vector3d point_step(std::size_t i, const Eigen::VectorXd& step) const {
    const Eliminated& e = eliminated_[i];
    Vector3d right = -e.g;
    for (const auto& [pose, W] : e.W) right -= W.transpose() * step.segment<6>(6 * pose);
    return e.V_inverse * right;
  }
  [[nodiscard]] const Matrix3d& point_covariance(std::size_t i) const { return eliminated_[i].V_inverse; }

 private:
  struct Eliminated {
    Matrix3d V_inverse = Matrix3d::Zero();
    Vector3d g = Vector3d::Zero();
    std::vector<std::pair<int, Eigen::Matrix<double, 6, 3>>> W;
  };

  void add(const RectifiedStereo& stereo, double sigma_px, const std::vector<Pose>& poses, const WindowPoint& point,
           double lambda, Eliminated& e) {
    Matrix3d V = Matrix3d::Zero();
    for (const Observation& o : point.observations) {
      const Pose T_cam_odom = poses[static_cast<std::size_t>(o.keyframe)].inverse();
      const Vector3d p = T_cam_odom * point.p_odom_m;
      if (p.z() < kMinDepthM) continue;
      const Vector3d r = residual(stereo, o, p, sigma_px);
      const double w = weight_of(r.squaredNorm());
      Matrix3d J_cam = project_jacobian(stereo, p) / sigma_px;
      if (!o.has_right) J_cam.row(2).setZero();
      const Matrix3d J_point = J_cam * T_cam_odom.linear();
      V.noalias() += w * J_point.transpose() * J_point;
      e.g.noalias() += w * J_point.transpose() * r;
      if (o.keyframe < fixed_) continue;
      const int pose = o.keyframe - fixed_;
      const Matrix36d J_pose = J_cam * point_by_pose_jacobian(p);
      H_.block<6, 6>(6 * pose, 6 * pose).noalias() += w * J_pose.transpose() * J_pose;
      g_.segment<6>(6 * pose).noalias() += w * J_pose.transpose() * r;
      e.W.emplace_back(pose, w * J_pose.transpose() * J_point);
    }
    V.diagonal() += lambda * V.diagonal();
    V.diagonal().array() += 1e-6;
    e.V_inverse = V.inverse();
    for (const auto& [a, W_a] : e.W) {
      const Eigen::Matrix<double, 6, 3> W_V = W_a * e.V_inverse;
      g_.segment<6>(6 * a).noalias() -= W_V * e.g;
      for (const auto& [b, W_b] : e.W) H_.block<6, 6>(6 * a, 6 * b).noalias() -= W_V * W_b.transpose();
    }
  }

  int fixed_;
  int free_;
  Eigen::MatrixXd H_;
  Eigen::VectorXd g_;
  std::vector<Eliminated> eliminated_;
};

}  // namespace

void refine_window(const RectifiedStereo& stereo, double pixel_sigma_px, int fixed, std::vector<Pose>& T_odom_cam,
                   std::vector<WindowPoint>& points) {
  double lambda = 1e-4;
  double before = total_loss(stereo, pixel_sigma_px, T_odom_cam, points);
  for (int i = 0; i < kMaxIterations; ++i) {
    const Problem problem(stereo, pixel_sigma_px, fixed, T_odom_cam, points, lambda);
    const Eigen::VectorXd step = problem.solve();
    std::vector<Pose> poses = T_odom_cam;
    std::vector<WindowPoint> moved = points;
    for (std::size_t k = static_cast<std::size_t>(fixed); k < poses.size(); ++k) {
      poses[k] = retract(poses[k], step.segment<6>(6 * (static_cast<int>(k) - fixed)));
    }
    for (std::size_t k = 0; k < moved.size(); ++k) {
      moved[k].p_odom_m += problem.point_step(k, step);
      moved[k].covariance_m2 = problem.point_covariance(k);
    }
    const double after = total_loss(stereo, pixel_sigma_px, poses, moved);
    if (!(after <= before)) {
      lambda *= 10;
      continue;
    }
    const bool converged = before - after < 1e-4 * before;
    T_odom_cam = std::move(poses);
    points = std::move(moved);
    before = after;
    lambda *= 0.1;
    if (converged) break;
  }
}

}  // namespace arpent::odometry
