// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/cube_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <optional>

namespace arpent::tags {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMinDepthM = 0.05;
constexpr int kIterations = 15;
/// Sides that fit this many times worse than they say are no sides of this cube.
constexpr double kMaxReducedChi2 = 4.0;
/// Two poses closer than this are one.
constexpr double kSamePoseM = 0.02;
constexpr double kSamePoseRad = 0.02;
/// Twice the log-likelihood by which the better of two poses must win.
constexpr double kAmbiguityMargin = 20.0;

struct Problem {
  const TagCube& cube;
  const RectifiedStereo& stereo;
  Pose T_body_cam;  ///< left
  std::vector<TagView> views;
};

struct Solution {
  Pose T_world_body = Pose::Identity();
  Matrix6d information = Matrix6d::Zero();
  double chi2 = 0;
};

Pose camera_of(const Problem& problem, bool right) {
  return right ? problem.T_body_cam * Eigen::Translation3d(problem.stereo.baseline_m, 0, 0) : problem.T_body_cam;
}

/// Derivative of a pixel by the tangent of retract(T_world_body, .), and the pixel.
struct Projected {
  Vector2d px;
  Eigen::Matrix<double, 2, 6> J;
  bool in_front = false;
};

Projected project(const PinholeCamera& camera, const Pose& T_body_cam, const Vector3d& p_body_m) {
  const Vector3d p = T_body_cam.inverse() * p_body_m;
  Projected projected;
  projected.in_front = p.z() > kMinDepthM;
  if (!projected.in_front) return projected;
  projected.px = camera.project(p);
  Eigen::Matrix<double, 2, 3> by_point;
  by_point << camera.fx_px / p.z(), 0, -camera.fx_px * p.x() / (p.z() * p.z()),  //
      0, camera.fy_px / p.z(), -camera.fy_px * p.y() / (p.z() * p.z());
  // p_body moves by -v - w x p_body when the body moves by (v, w) in its own axes.
  Eigen::Matrix<double, 3, 6> by_pose;
  by_pose.leftCols<3>() = -Eigen::Matrix3d::Identity();
  by_pose.rightCols<3>() << 0, -p_body_m.z(), p_body_m.y(),  //
      p_body_m.z(), 0, -p_body_m.x(),                        //
      -p_body_m.y(), p_body_m.x(), 0;
  projected.J = by_point * T_body_cam.linear().transpose() * by_pose;
  return projected;
}

/// Adds one view's sides to the normal equations; the distances of a side's two corners from the fitted line are one
/// measurement with the line's covariance. False if the tag would be behind the camera.
bool add_view(const Problem& problem, const TagView& view, const Pose& T_world_body, Solution& sums, Vector6d& g) {
  const TagCorners& corners = *problem.cube.find_corners(view.id);
  const Pose T_body_cam = camera_of(problem, view.in_right);
  std::array<Projected, 4> seen;
  for (std::size_t k = 0; k < 4; ++k) {
    seen[k] = project(problem.stereo.camera, T_body_cam, T_world_body.inverse() * corners[k]);
    if (!seen[k].in_front) return false;
  }
  for (std::size_t k = 0; k < 4; ++k) {
    const TagSide& side = view.outline.sides[k];
    const std::array<const Projected*, 2> ends{&seen[k], &seen[(k + 1) % 4]};
    Vector2d r;
    Eigen::Matrix<double, 2, 6> J;
    for (int e = 0; e < 2; ++e) {
      const Projected& end = *ends[static_cast<std::size_t>(e)];
      r[e] = side.normal.dot(end.px) - side.offset_px;
      J.row(e) = side.normal.transpose() * end.J;
    }
    const Eigen::LLT<Eigen::Matrix2d> llt(side.covariance_px2);
    llt.matrixL().solveInPlace(r);
    llt.matrixL().solveInPlace(J);
    sums.information.noalias() += J.transpose() * J;
    g.noalias() += J.transpose() * r;
    sums.chi2 += r.squaredNorm();
  }
  return true;
}

/// The normal equations at a pose; nullopt if a tag would be behind the camera.
std::optional<std::pair<Solution, Vector6d>> linearize(const Problem& problem, const Pose& T_world_body) {
  Solution sums;
  sums.T_world_body = T_world_body;
  Vector6d g = Vector6d::Zero();
  for (const TagView& view : problem.views) {
    if (!add_view(problem, view, T_world_body, sums, g)) return std::nullopt;
  }
  return std::make_pair(sums, g);
}

/// Levenberg-Marquardt from a start; nullopt if it is behind the camera from the beginning.
std::optional<Solution> refine(const Problem& problem, const Pose& start) {
  auto at = linearize(problem, start);
  double damping = 1e-4;
  for (int i = 0; at && i < kIterations; ++i) {
    Matrix6d H = at->first.information;
    H.diagonal() *= 1 + damping;
    const Vector6d step = H.ldlt().solve(-at->second);
    if (!step.allFinite()) return std::nullopt;
    auto next = linearize(problem, retract(at->first.T_world_body, step));
    const bool better = next && next->first.chi2 <= at->first.chi2;
    damping = better ? damping * 0.1 : damping * 10;
    if (better) at = std::move(next);
    if (step.norm() < 1e-8) break;
  }
  if (!at) return std::nullopt;
  return at->first;
}

/// The two poses of the body that one square in one image allows.
std::vector<Pose> start_poses(const Problem& problem, const TagView& view) {
  const double half_m = 0.5 * problem.cube.tag_m();
  // Top left, top right, bottom right, bottom left with x right, y down, z into the face: near the camera's own axes,
  // since OpenCV 4.6 makes wrong vectors of the rotations by exactly half a turn that a level camera has otherwise.
  const std::vector<cv::Point3d> square{
      {-half_m, -half_m, 0}, {half_m, -half_m, 0}, {half_m, half_m, 0}, {-half_m, half_m, 0}};
  std::vector<cv::Point2d> pixels;
  for (std::size_t k = 4; k-- > 0;) pixels.emplace_back(view.outline.corners_px[k].x(), view.outline.corners_px[k].y());
  const PinholeCamera& c = problem.stereo.camera;
  const cv::Matx33d K(c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1);
  std::vector<cv::Mat> rotations, translations;
  cv::solvePnPGeneric(square, pixels, K, cv::noArray(), rotations, translations, false, cv::SOLVEPNP_IPPE);
  const TagCorners& corners = *problem.cube.find_corners(view.id);
  Pose T_world_tag = Pose::Identity();
  T_world_tag.translation() = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  T_world_tag.linear().col(0) = (corners[1] - corners[0]).normalized();
  T_world_tag.linear().col(1) = (corners[0] - corners[3]).normalized();
  T_world_tag.linear().col(2) = T_world_tag.linear().col(0).cross(T_world_tag.linear().col(1));
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const cv::Vec3d r(rotations[i].ptr<double>());
    const cv::Vec3d t(translations[i].ptr<double>());
    Pose T_cam_tag = Pose::Identity();
    T_cam_tag.linear() = so3_exp({r[0], r[1], r[2]});
    T_cam_tag.translation() = Vector3d(t[0], t[1], t[2]);
    if (!T_cam_tag.matrix().allFinite()) continue;
    poses.push_back(T_world_tag * T_cam_tag.inverse() * camera_of(problem, view.in_right).inverse());
  }
  return poses;
}

bool are_same(const Pose& a, const Pose& b) {
  const Vector6d d = local(a, b);
  return d.head<3>().norm() < kSamePoseM && d.tail<3>().norm() < kSamePoseRad;
}

bool has_stereo(const std::vector<TagView>& views) {
  return std::any_of(views.begin(), views.end(), [&](const TagView& a) {
    return std::any_of(views.begin(), views.end(),
                       [&](const TagView& b) { return a.id == b.id && a.in_right != b.in_right; });
  });
}

/// The best pose over all starts, or why there is none.
CubePose solve(const Problem& problem) {
  CubePose result;
  std::vector<Solution> solutions;
  for (const TagView& view : problem.views) {
    if (std::find(result.used.begin(), result.used.end(), view.id) == result.used.end()) result.used.push_back(view.id);
    for (const Pose& start : start_poses(problem, view)) {
      if (const auto solution = refine(problem, start)) solutions.push_back(*solution);
    }
  }
  if (solutions.empty()) {
    result.reason = "no pose shows the tags where they were seen";
    return result;
  }
  const auto by_chi2 = [](const Solution& a, const Solution& b) { return a.chi2 < b.chi2; };
  const Solution best = *std::min_element(solutions.begin(), solutions.end(), by_chi2);
  const double freedom = 8.0 * static_cast<double>(problem.views.size()) - 6.0;
  result.T_world_body = best.T_world_body;
  result.reduced_chi2 = best.chi2 / freedom;
  result.covariance = best.information.ldlt().solve(Matrix6d::Identity()) * std::max(1.0, result.reduced_chi2);
  const bool ambiguous = std::any_of(solutions.begin(), solutions.end(), [&](const Solution& s) {
    return s.chi2 < best.chi2 + kAmbiguityMargin && !are_same(s.T_world_body, best.T_world_body);
  });
  if (!result.covariance.allFinite()) {
    result.reason = "the tags leave the pose undetermined";
  } else if (!(result.reduced_chi2 <= kMaxReducedChi2)) {
    result.reason = "the tags do not fit the cube";
  } else if (ambiguous) {
    result.reason = "two poses fit the tags";
  }
  return result;
}

std::vector<TagView> without(const std::vector<TagView>& views, int id) {
  std::vector<TagView> rest;
  std::copy_if(views.begin(), views.end(), std::back_inserter(rest), [&](const TagView& v) { return v.id != id; });
  return rest;
}

}  // namespace

CubePose solve_cube_pose(const TagCube& cube, const RectifiedStereo& stereo, const Pose& T_body_cam,
                         const std::vector<TagView>& views) {
  if (!has_stereo(views)) {
    CubePose none;
    none.reason = "no tag of the cube was seen in both images";
    return none;
  }
  CubePose whole = solve({cube, stereo, T_body_cam, views});
  if (whole.usable() || whole.used.size() < 2) return whole;
  // One tag may be wrong; if more than one choice of it makes the rest fit, if only ambiguously, nobody knows which.
  std::vector<CubePose> fitting;
  for (const int id : whole.used) {
    const std::vector<TagView> rest = without(views, id);
    if (!has_stereo(rest)) continue;
    const CubePose part = solve({cube, stereo, T_body_cam, rest});
    if (part.reduced_chi2 <= kMaxReducedChi2) fitting.push_back(part);
  }
  if (fitting.size() == 1) return fitting.front();
  if (fitting.size() > 1) whole.reason = "the tags contradict each other";
  return whole;
}

GroundedPose put_on_ground(const Pose& T_world_body, const Matrix6d& covariance, const GroundParams& params) {
  const Eigen::Matrix3d R = T_world_body.linear();
  const Vector3d h(T_world_body.translation().z(), R(0, 2), R(1, 2));  // height and the lean of the z axis
  Eigen::Matrix<double, 3, 6> H = Eigen::Matrix<double, 3, 6>::Zero();
  H.block<1, 3>(0, 0) = R.row(2);
  Eigen::Matrix3d lean;  // d(R e_z) by the tangent: -R [e_z]x
  lean << R.col(1) * -1.0, R.col(0), Vector3d::Zero();
  H.block<2, 3>(1, 3) = lean.topRows<2>();
  Eigen::Matrix3d S = H * covariance * H.transpose();
  S(0, 0) += params.height_sigma_m * params.height_sigma_m;
  S(1, 1) += params.tilt_sigma_rad * params.tilt_sigma_rad;
  S(2, 2) += params.tilt_sigma_rad * params.tilt_sigma_rad;
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(S);
  const Eigen::Matrix<double, 6, 3> K = ldlt.solve(H * covariance).transpose();
  GroundedPose grounded;
  grounded.T_world_body = retract(T_world_body, -K * h);
  grounded.covariance = covariance - K * H * covariance;
  grounded.covariance = (0.5 * (grounded.covariance + grounded.covariance.transpose())).eval();
  grounded.chi2 = h.dot(ldlt.solve(h));
  return grounded;
}

}  // namespace arpent::tags
