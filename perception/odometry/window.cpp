// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/odometry/window.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
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

Vector3d residual(const RectifiedStereo& stereo, const Observation& o, const Vector3d& p_cam, double sigma_px,
                  double offset_px) {
  Vector3d r = (project(stereo, p_cam) - o.z_px + Vector3d(0, 0, offset_px)) / sigma_px;
  if (!o.has_right) r.z() = 0;
  return r;
}

double total_loss(const RectifiedStereo& stereo, double sigma_px, const std::vector<Pose>& poses,
                  const std::vector<WindowPoint>& points, const DisparityOffset& prior, double offset_px) {
  double sum = (offset_px - prior.px) * (offset_px - prior.px) / prior.variance_px2;
  for (const WindowPoint& point : points) {
    for (const Observation& o : point.observations) {
      const Vector3d p = poses[static_cast<std::size_t>(o.keyframe)].inverse() * point.p_odom_m;
      sum += p.z() < kMinDepthM ? loss(1e4) : loss(residual(stereo, o, p, sigma_px, offset_px).squaredNorm());
    }
  }
  return sum;
}

/// The normal equations, with points eliminated: the free poses, and the disparity offset in the last row.
class Problem {
 public:
  Problem(const RectifiedStereo& stereo, double sigma_px, int fixed, const std::vector<Pose>& poses,
          const std::vector<WindowPoint>& points, const DisparityOffset& prior, double offset_px, double lambda)
      : fixed_(fixed),
        offset_(6 * (static_cast<int>(poses.size()) - fixed)),
        H_(offset_ + 1, offset_ + 1),
        g_(offset_ + 1) {
    H_.setZero();
    g_.setZero();
    H_(offset_, offset_) = 1 / prior.variance_px2;
    g_(offset_) = (offset_px - prior.px) / prior.variance_px2;
    eliminated_.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      add(stereo, sigma_px, poses, points[i], offset_px, lambda, eliminated_[i]);
    }
    for (int i = 0; i <= offset_; ++i) H_(i, i) += lambda * H_(i, i) + 1e-9;
  }

  /// Variance of the offset with everything else unknown.
  [[nodiscard]] double offset_variance() const {
    return H_.ldlt().solve(Eigen::VectorXd::Unit(offset_ + 1, offset_))(offset_);
  }

  /// The steps of the free poses, stacked, and of the offset.
  [[nodiscard]] Eigen::VectorXd solve() const { return H_.ldlt().solve(-g_); }

  /// The step of point `i` that belongs to the poses' step.
  [[nodiscard]] Vector3d point_step(std::size_t i, const Eigen::VectorXd& step) const {
    const Eliminated& e = eliminated_[i];
    Vector3d right = -e.g;
    for (const auto& [pose, W] : e.W) right -= W.transpose() * step.segment<6>(6 * pose);
    right -= e.W_offset.transpose() * step(offset_);
    return e.V_inverse * right;
  }
  [[nodiscard]] const Matrix3d& point_covariance(std::size_t i) const { return eliminated_[i].V_inverse; }

 private:
  struct Eliminated {
    Matrix3d V_inverse = Matrix3d::Zero();
    Vector3d g = Vector3d::Zero();
    std::vector<std::pair<int, Eigen::Matrix<double, 6, 3>>> W;
    Eigen::RowVector3d W_offset = Eigen::RowVector3d::Zero();
  };

  void add(const RectifiedStereo& stereo, double sigma_px, const std::vector<Pose>& poses, const WindowPoint& point,
           double offset_px, double lambda, Eliminated& e) {
    Matrix3d V = Matrix3d::Zero();
    for (const Observation& o : point.observations) {
      const Pose T_cam_odom = poses[static_cast<std::size_t>(o.keyframe)].inverse();
      const Vector3d p = T_cam_odom * point.p_odom_m;
      if (p.z() < kMinDepthM) continue;
      const Vector3d r = residual(stereo, o, p, sigma_px, offset_px);
      const double w = weight_of(r.squaredNorm());
      Matrix3d J_cam = project_jacobian(stereo, p) / sigma_px;
      if (!o.has_right) J_cam.row(2).setZero();
      const Matrix3d J_point = J_cam * T_cam_odom.linear();
      V.noalias() += w * J_point.transpose() * J_point;
      e.g.noalias() += w * J_point.transpose() * r;
      if (o.has_right) {  // the offset moves the third residual only
        H_(offset_, offset_) += w / (sigma_px * sigma_px);
        g_(offset_) += w * r.z() / sigma_px;
        e.W_offset.noalias() += w / sigma_px * J_point.row(2);
      }
      if (o.keyframe < fixed_) continue;
      const int pose = o.keyframe - fixed_;
      const Matrix36d J_pose = J_cam * point_by_pose_jacobian(p);
      H_.block<6, 6>(6 * pose, 6 * pose).noalias() += w * J_pose.transpose() * J_pose;
      g_.segment<6>(6 * pose).noalias() += w * J_pose.transpose() * r;
      e.W.emplace_back(pose, w * J_pose.transpose() * J_point);
      if (!o.has_right) continue;
      const Vector6d cross = w / sigma_px * J_pose.row(2).transpose();
      H_.block<6, 1>(6 * pose, offset_) += cross;
      H_.block<1, 6>(offset_, 6 * pose) += cross.transpose();
    }
    V.diagonal() += lambda * V.diagonal();
    V.diagonal().array() += 1e-6;
    e.V_inverse = V.inverse();
    const Eigen::RowVector3d W_V_offset = e.W_offset * e.V_inverse;
    H_(offset_, offset_) -= W_V_offset.dot(e.W_offset);
    g_(offset_) -= W_V_offset * e.g;
    for (const auto& [a, W_a] : e.W) {
      const Vector6d cross = W_a * W_V_offset.transpose();
      H_.block<6, 1>(6 * a, offset_) -= cross;
      H_.block<1, 6>(offset_, 6 * a) -= cross.transpose();
      const Eigen::Matrix<double, 6, 3> W_V = W_a * e.V_inverse;
      g_.segment<6>(6 * a).noalias() -= W_V * e.g;
      for (const auto& [b, W_b] : e.W) H_.block<6, 6>(6 * a, 6 * b).noalias() -= W_V * W_b.transpose();
    }
  }

  int fixed_;
  int offset_;  ///< row of the disparity offset
  Eigen::MatrixXd H_;
  Eigen::VectorXd g_;
  std::vector<Eliminated> eliminated_;
};

}  // namespace

void refine_window(const RectifiedStereo& stereo, double pixel_sigma_px, int fixed, double information_share,
                   std::vector<Pose>& T_odom_cam, std::vector<WindowPoint>& points, DisparityOffset& offset) {
  const DisparityOffset prior = offset;
  double lambda = 1e-4;
  double before = total_loss(stereo, pixel_sigma_px, T_odom_cam, points, prior, offset.px);
  for (int i = 0; i < kMaxIterations; ++i) {
    const Problem problem(stereo, pixel_sigma_px, fixed, T_odom_cam, points, prior, offset.px, lambda);
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
    const double moved_offset_px = offset.px + step(step.size() - 1);
    const double after = total_loss(stereo, pixel_sigma_px, poses, moved, prior, moved_offset_px);
    if (!(after <= before)) {
      lambda *= 10;
      continue;
    }
    const bool converged = before - after < 1e-4 * before;
    T_odom_cam = std::move(poses);
    points = std::move(moved);
    offset.px = moved_offset_px;
    const double added = std::max(1 / problem.offset_variance() - 1 / prior.variance_px2, 0.0);
    offset.variance_px2 = 1 / (1 / prior.variance_px2 + information_share * added);
    before = after;
    lambda *= 0.1;
    if (converged) break;
  }
}

}  // namespace arpent::odometry
