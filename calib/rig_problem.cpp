// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/rig_problem.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <limits>
#include <memory>

#include "common/error.h"

namespace arpent::calib {
namespace {

constexpr int kPoseParameters = 6;
/// Translation [m], rotation vector [rad].
using PoseParameters = std::array<double, kPoseParameters>;

PoseParameters to_array(const Pose& T) {
  const Eigen::Vector3d t = T.translation(), w = so3_log(T.linear());
  return {t.x(), t.y(), t.z(), w.x(), w.y(), w.z()};
}
Pose to_pose(const PoseParameters& a) {
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(a[0], a[1], a[2]);
  T.linear() = so3_exp({a[3], a[4], a[5]});
  return T;
}

template <class T>
void transform(const T* pose, const T* p, T* out) {
  ceres::AngleAxisRotatePoint(pose + 3, p, out);
  for (int i = 0; i < 3; ++i) out[i] += pose[i];
}

struct Reprojection {
  DistortionModel model;
  Eigen::Vector2d board_m;
  Eigen::Vector2d px;

  template <class T>
  bool operator()(const T* lens, const T* T_first_board, T* residual) const {
    const T p_board[3] = {T(board_m.x()), T(board_m.y()), T(0)};
    T p_cam[3];
    transform(T_first_board, p_board, p_cam);
    return difference(lens, p_cam, residual);
  }
  template <class T>
  bool operator()(const T* lens, const T* T_cam_first, const T* T_first_board, T* residual) const {
    const T p_board[3] = {T(board_m.x()), T(board_m.y()), T(0)};
    T p_first[3], p_cam[3];
    transform(T_first_board, p_board, p_first);
    transform(T_cam_first, p_first, p_cam);
    return difference(lens, p_cam, residual);
  }

 private:
  template <class T>
  bool difference(const T* lens, const T* p_cam, T* residual) const {
    if (!project(model, lens, p_cam, residual)) return false;
    residual[0] -= T(px.x());
    residual[1] -= T(px.y());
    return true;
  }
};

/// A Ceres problem over copies of the estimate's numbers.
class Problem {
 public:
  Problem(const std::vector<Observation>& observations, const RigEstimate& rig, double cauchy_px) {
    for (const RawCamera& camera : rig.cameras) lenses_.push_back(to_parameters(camera));
    for (const Pose& T : rig.T_cam_first) mounts_.push_back(to_array(T));
    for (const Pose& T : rig.T_first_board) boards_.push_back(to_array(T));
    ceres::LossFunction* loss = cauchy_px > 0 ? new ceres::CauchyLoss(cauchy_px) : nullptr;
    seen_.assign(boards_.size(), false);
    std::vector<bool> used(lenses_.size(), false);
    for (const Observation& o : observations) {
      const auto c = static_cast<std::size_t>(o.camera), v = static_cast<std::size_t>(o.view);
      auto functor = std::make_unique<Reprojection>(Reprojection{rig.cameras[c].distortion, o.board_m, o.px});
      seen_[v] = used[c] = true;
      if (c == 0) {
        problem_.AddResidualBlock(
            new ceres::AutoDiffCostFunction<Reprojection, 2, kLensParameters, kPoseParameters>(functor.release()), loss,
            lenses_[c].data(), boards_[v].data());
      } else {
        problem_.AddResidualBlock(
            new ceres::AutoDiffCostFunction<Reprojection, 2, kLensParameters, kPoseParameters, kPoseParameters>(
                functor.release()),
            loss, lenses_[c].data(), mounts_[c].data(), boards_[v].data());
      }
    }
    for (std::size_t c = 0; c < used.size(); ++c) {
      if (used[c]) camera_blocks_.push_back(lenses_[c].data());
    }
    for (std::size_t c = 1; c < used.size(); ++c) {
      if (used[c]) camera_blocks_.push_back(mounts_[c].data());
    }
  }

  double solve(const SolveOptions& options) {
    if (options.fix_cameras) {
      for (double* block : camera_blocks_) problem_.SetParameterBlockConstant(block);
    } else if (options.fix_distortion) {
      for (auto& lens : lenses_) {
        if (problem_.HasParameterBlock(lens.data())) {
          problem_.SetManifold(lens.data(), new ceres::SubsetManifold(kLensParameters, {4, 5, 6, 7}));
        }
      }
    }
    ceres::Solver::Options solver;
    solver.linear_solver_type = options.fix_cameras ? ceres::SPARSE_NORMAL_CHOLESKY : ceres::DENSE_SCHUR;
    solver.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (std::size_t v = 0; v < boards_.size(); ++v) {
      if (seen_[v]) solver.linear_solver_ordering->AddElementToGroup(boards_[v].data(), 0);
    }
    for (double* block : camera_blocks_) solver.linear_solver_ordering->AddElementToGroup(block, 1);
    if (options.fix_cameras) solver.linear_solver_ordering.reset();
    solver.max_num_iterations = options.max_iterations;
    solver.function_tolerance = 1e-16;
    solver.parameter_tolerance = 1e-16;
    solver.gradient_tolerance = 1e-16;
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    return summary.IsSolutionUsable() ? summary.final_cost : std::numeric_limits<double>::infinity();
  }

  void store(RigEstimate& rig) const {
    for (std::size_t c = 0; c < lenses_.size(); ++c) {
      rig.cameras[c] = with_parameters(rig.cameras[c], lenses_[c]);
      rig.T_cam_first[c] = to_pose(mounts_[c]);
    }
    for (std::size_t v = 0; v < boards_.size(); ++v) rig.T_first_board[v] = to_pose(boards_[v]);
  }

  /// J^T J, cameras first, then the boards that are seen; nothing if it cannot be evaluated.
  Eigen::MatrixXd information() {
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = camera_blocks_;
    for (std::size_t v = 0; v < boards_.size(); ++v) {
      if (seen_[v]) options.parameter_blocks.push_back(boards_[v].data());
    }
    ceres::CRSMatrix J;
    if (!problem_.Evaluate(options, nullptr, nullptr, nullptr, &J)) return {};
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(J.num_cols, J.num_cols);
    for (std::size_t row = 0; row < static_cast<std::size_t>(J.num_rows); ++row) {
      const auto begin = static_cast<std::size_t>(J.rows[row]), end = static_cast<std::size_t>(J.rows[row + 1]);
      for (std::size_t a = begin; a < end; ++a) {
        for (std::size_t b = begin; b < end; ++b) H(J.cols[a], J.cols[b]) += J.values[a] * J.values[b];
      }
    }
    return H;
  }

 private:
  std::vector<LensParameters> lenses_;
  std::vector<PoseParameters> mounts_, boards_;
  std::vector<bool> seen_;
  std::vector<double*> camera_blocks_;
  ceres::Problem problem_;
};

}  // namespace

double solve(const std::vector<Observation>& observations, RigEstimate& rig, const SolveOptions& options) {
  ARPENT_ASSERT(!observations.empty());
  Problem problem(observations, rig, options.cauchy_px);
  const double cost = problem.solve(options);
  problem.store(rig);
  return cost;
}

std::vector<Eigen::Vector2d> residuals(const std::vector<Observation>& observations, const RigEstimate& rig) {
  std::vector<Eigen::Vector2d> errors;
  errors.reserve(observations.size());
  for (const Observation& o : observations) {
    const auto c = static_cast<std::size_t>(o.camera), v = static_cast<std::size_t>(o.view);
    const Eigen::Vector3d p_cam =
        rig.T_cam_first[c] * (rig.T_first_board[v] * Eigen::Vector3d(o.board_m.x(), o.board_m.y(), 0));
    const LensParameters lens = to_parameters(rig.cameras[c]);
    Eigen::Vector2d px;
    const bool seen = project(rig.cameras[c].distortion, lens.data(), p_cam.data(), px.data());
    errors.push_back(seen ? Eigen::Vector2d(px - o.px)
                          : Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()));
  }
  return errors;
}

Eigen::MatrixXd unit_covariance(const std::vector<Observation>& observations, const RigEstimate& rig) {
  const Eigen::MatrixXd H = Problem(observations, rig, 0).information();
  const auto n =
      static_cast<Eigen::Index>(kLensParameters * rig.cameras.size() + kPoseParameters * (rig.cameras.size() - 1));
  if (H.rows() < n) return {};
  // Unit diagonal: metres, pixels and radians become comparable for the test of rank.
  const Eigen::VectorXd scale = H.diagonal().cwiseSqrt();
  if (!(scale.minCoeff() > 0)) return {};
  const Eigen::MatrixXd scaled = scale.cwiseInverse().asDiagonal() * H * scale.cwiseInverse().asDiagonal();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(scaled);
  constexpr double kLeastPivot = 1e-13;
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > kLeastPivot)) return {};
  const Eigen::MatrixXd columns = ldlt.solve(Eigen::MatrixXd::Identity(H.rows(), n));
  const Eigen::VectorXd s = scale.head(n).cwiseInverse();
  return s.asDiagonal() * columns.topRows(n) * s.asDiagonal();
}

}  // namespace arpent::calib
