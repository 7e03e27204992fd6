// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/odometry/pose_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <random>

namespace arpent::odometry {
namespace {

constexpr double kMinDepthM = 0.05;
constexpr int kMinInliers = 4;
constexpr double kConfidence = 0.999;
constexpr int kRefinements = 8;
/// Cauchy loss: a residual of this many standard deviations counts half.
constexpr double kLossWidth = 2.5;
/// chi-squared quantile for two coordinates at 99.9 %: beyond it a measurement is no inlier of the refined pose.
constexpr double kGate2 = 13.8;

bool agrees(const RectifiedStereo& stereo, const PointMeasurement& m, const Pose& T_cam_odom, double threshold_px) {
  const Vector3d p = T_cam_odom * m.p_odom_m;
  if (p.z() < kMinDepthM) return false;
  const Vector3d r = project(stereo, p) - m.z_px;
  return r.head<2>().squaredNorm() < threshold_px * threshold_px &&
         (!m.has_right || std::abs(r.z()) < 2 * threshold_px);
}

int count(const RectifiedStereo& stereo, const std::vector<PointMeasurement>& all, const Pose& T_odom_cam,
          double threshold_px) {
  const Pose T_cam_odom = T_odom_cam.inverse();
  return static_cast<int>(std::count_if(
      all.begin(), all.end(), [&](const PointMeasurement& m) { return agrees(stereo, m, T_cam_odom, threshold_px); }));
}

/// The up to four poses that three points allow.
std::vector<Pose> p3p(const RectifiedStereo& stereo, const std::array<const PointMeasurement*, 3>& sample) {
  const PinholeCamera& c = stereo.camera;
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  // Centred coordinates keep the quartic well conditioned far from the origin.
  const Vector3d origin = sample[0]->p_odom_m;
  for (const PointMeasurement* m : sample) {
    const Vector3d p = m->p_odom_m - origin;
    points.emplace_back(p.x(), p.y(), p.z());
    pixels.emplace_back(m->z_px.x(), m->z_px.y());
  }
  const cv::Matx33d K(c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1);
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  cv::solveP3P(points, pixels, K, cv::noArray(), rotations, translations, cv::SOLVEPNP_AP3P);
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const cv::Vec3d r(rotations[i].ptr<double>());
    const cv::Vec3d t(translations[i].ptr<double>());
    Pose T_cam_centred = Pose::Identity();
    T_cam_centred.linear() = so3_exp({r[0], r[1], r[2]});
    T_cam_centred.translation() = Vector3d(t[0], t[1], t[2]);
    Pose T_odom_cam = T_cam_centred.inverse();
    T_odom_cam.translation() += origin;
    if (T_odom_cam.matrix().allFinite()) poses.push_back(T_odom_cam);
  }
  return poses;
}

int iterations_needed(int inliers, std::size_t total, int limit) {
  const double share = static_cast<double>(inliers) / static_cast<double>(total);
  const double failure = 1.0 - share * share * share;
  if (failure <= 1e-9) return 1;
  const double wanted = std::log(1.0 - kConfidence) / std::log(std::min(failure, 1.0 - 1e-9));
  return static_cast<int>(std::ceil(std::min(wanted, static_cast<double>(limit))));
}

Pose ransac(const RectifiedStereo& stereo, const std::vector<PointMeasurement>& all, const Pose& guess,
            std::uint64_t seed, const PoseSolverOptions& options) {
  Pose best = guess;
  int most = count(stereo, all, guess, options.ransac_threshold_px);
  if (all.size() < 4) return best;
  std::mt19937_64 generator(seed);
  int needed = iterations_needed(most, all.size(), options.ransac_iterations);
  for (int i = 0; i < needed; ++i) {
    std::array<const PointMeasurement*, 3> sample{};
    for (auto& m : sample) m = &all[generator() % all.size()];
    if (sample[0] == sample[1] || sample[0] == sample[2] || sample[1] == sample[2]) continue;
    for (const Pose& pose : p3p(stereo, sample)) {
      const int agreeing = count(stereo, all, pose, options.ransac_threshold_px);
      if (agreeing <= most) continue;
      most = agreeing;
      best = pose;
      needed = iterations_needed(most, all.size(), options.ransac_iterations);
    }
  }
  return best;
}

/// One measurement, whitened: residual and Jacobian by the pose, and their squared norm. Rows without a right image are
/// zero.
struct Whitened {
  Vector3d r;
  Eigen::Matrix<double, 3, 6> J;
  double chi2 = 0;
};

Whitened whiten(const RectifiedStereo& stereo, const PointMeasurement& m, const Pose& T_cam_odom, double sigma_px) {
  const Vector3d p = T_cam_odom * m.p_odom_m;
  const Matrix3d J_point = project_jacobian(stereo, p);
  const Matrix3d J_odom = J_point * T_cam_odom.linear();
  Matrix3d S = J_odom * m.covariance_m2 * J_odom.transpose();
  S.diagonal().array() += sigma_px * sigma_px;
  if (!m.has_right) {
    S.row(2).setZero();
    S.col(2).setZero();
    S(2, 2) = 1e12;
  }
  const Eigen::LLT<Matrix3d> llt(S);
  Whitened w;
  w.r = llt.matrixL().solve(project(stereo, p) - m.z_px);
  w.J = llt.matrixL().solve(J_point * point_by_pose_jacobian(p));
  if (!m.has_right) w.r.z() = 0;
  w.chi2 = w.r.squaredNorm();
  return w;
}

/// Iteratively reweighted Gauss-Newton over the inliers; fills pose and covariance.
void refine(const RectifiedStereo& stereo, const std::vector<PointMeasurement>& all, double sigma_px,
            PoseSolution& solution) {
  for (int i = 0; i < kRefinements; ++i) {
    const Pose T_cam_odom = solution.T_odom_cam.inverse();
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (!solution.inlier[k] || (T_cam_odom * all[k].p_odom_m).z() < kMinDepthM) continue;
      const Whitened w = whiten(stereo, all[k], T_cam_odom, sigma_px);
      const double weight = 1.0 / (1.0 + w.chi2 / (kLossWidth * kLossWidth));
      H.noalias() += weight * w.J.transpose() * w.J;
      g.noalias() += weight * w.J.transpose() * w.r;
    }
    H.diagonal().array() += 1e-9;
    const Eigen::LDLT<Matrix6d> ldlt(H);
    const Vector6d step = ldlt.solve(-g);
    if (!step.allFinite()) return;
    solution.T_odom_cam = retract(solution.T_odom_cam, step);
    solution.covariance = ldlt.solve(Matrix6d::Identity());
    if (step.norm() < 1e-8) break;
  }
}

void mark(const RectifiedStereo& stereo, const std::vector<PointMeasurement>& all, double threshold_px,
          PoseSolution& solution) {
  const Pose T_cam_odom = solution.T_odom_cam.inverse();
  for (std::size_t k = 0; k < all.size(); ++k) {
    solution.inlier[k] = agrees(stereo, all[k], T_cam_odom, threshold_px);
  }
}

/// Keeps what fits the refined pose within its own uncertainty, and inflates the covariance if the residuals are larger
/// than stated.
void gate(const RectifiedStereo& stereo, const std::vector<PointMeasurement>& all, double sigma_px,
          PoseSolution& solution) {
  const Pose T_cam_odom = solution.T_odom_cam.inverse();
  double chi2 = 0;
  double squares = 0;
  int coordinates = 0;
  solution.inliers = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Vector3d p = T_cam_odom * all[k].p_odom_m;
    solution.inlier[k] = solution.inlier[k] && p.z() >= kMinDepthM;
    if (!solution.inlier[k]) continue;
    const Whitened w = whiten(stereo, all[k], T_cam_odom, sigma_px);
    solution.inlier[k] = w.chi2 < 2.0 * kGate2;
    if (!solution.inlier[k]) continue;
    ++solution.inliers;
    chi2 += w.chi2;
    coordinates += all[k].has_right ? 3 : 2;
    squares += (project(stereo, p) - all[k].z_px).head<2>().squaredNorm();
  }
  if (solution.inliers < kMinInliers) return;
  solution.rms_px = std::sqrt(squares / solution.inliers);
  solution.covariance *= std::max(1.0, chi2 / std::max(1, coordinates - 6));
}

}  // namespace

PoseSolution solve_pose(const RectifiedStereo& stereo, const std::vector<PointMeasurement>& measurements,
                        const Pose& guess, std::uint64_t seed, const PoseSolverOptions& options) {
  PoseSolution solution;
  solution.inlier.assign(measurements.size(), false);
  solution.T_odom_cam = ransac(stereo, measurements, guess, seed, options);
  mark(stereo, measurements, options.ransac_threshold_px, solution);
  solution.inliers = static_cast<int>(std::count(solution.inlier.begin(), solution.inlier.end(), true));
  if (solution.inliers < kMinInliers) {
    solution.T_odom_cam = guess;
    return solution;
  }
  refine(stereo, measurements, options.pixel_sigma_px, solution);
  mark(stereo, measurements, options.ransac_threshold_px, solution);
  refine(stereo, measurements, options.pixel_sigma_px, solution);
  gate(stereo, measurements, options.pixel_sigma_px, solution);
  return solution;
}

}  // namespace arpent::odometry
