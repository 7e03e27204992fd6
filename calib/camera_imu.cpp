// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/camera_imu.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

#include "calib/camera_imu_errors.h"
#include "calib/camera_imu_start.h"
#include "calib/least_squares.h"
#include "common/error.h"

namespace arpent::calib {
namespace {

using namespace camera_imu;

constexpr double kLeastDurationS = 5, kLeastTurnedRad = 3;
/// Holds an offset that the motion does not show where it is.
constexpr double kHeldS = 1e-6;
constexpr double kGravityMps2 = 9.81, kGravityDeviationMps2 = 0.03;
constexpr double kHuber = 3;

Eigen::Matrix3d cross(const Eigen::Vector3d& w) {
  Eigen::Matrix3d W;
  W << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return W;
}

/// Noise of the readings' sum (Forster et al. 2017, eq. A.7), with a little for readings between samples.
Matrix9d noise_of(const Readings& readings, double from_s, double to_s, const CameraImuInput& input) {
  Matrix9d C = 1e-12 * Matrix9d::Identity();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  readings.walk<double>(from_s, to_s, [&](double dt, const Eigen::Vector3d& turn, const Eigen::Vector3d& force) {
    Matrix9d A = Matrix9d::Identity();
    A.block<3, 3>(0, 0) = so3_exp(turn * dt).transpose();
    A.block<3, 3>(3, 0) = -R * cross(force) * dt;
    A.block<3, 3>(6, 0) = -0.5 * R * cross(force) * dt * dt;
    A.block<3, 3>(6, 3) = dt * Eigen::Matrix3d::Identity();
    const double gyro2 = std::pow(input.gyro_noise_radpsrthz, 2) * dt;
    const double force2 = std::pow(input.accelerometer_noise_mps2rthz, 2) * dt;
    C = A * C * A.transpose();
    C.block<3, 3>(0, 0) += gyro2 * Eigen::Matrix3d::Identity();
    C.block<3, 3>(3, 3) += force2 * Eigen::Matrix3d::Identity();
    C.block<3, 3>(6, 6) += force2 * dt * dt / 3 * Eigen::Matrix3d::Identity();
    R = R * so3_exp(turn * dt);
  });
  return C;
}

/// The least squares problem: mounting, biases, gravity, and pose and speed at every moment of the camera.
class CameraImuProblem {
 public:
  CameraImuProblem(const CameraImuInput& input, const Readings& readings, const std::vector<Span>& spans,
                   const Offset& offset)
      : input_(input), readings_(readings), offset_shown_(offset.shown) {
    R_cam_imu_ = align_turns(input, readings, spans, offset.s);
    const Eigen::Vector3d place = input.T_cam_imu.translation();
    mount_ = {0, 0, 0, place.x(), place.y(), place.z(), offset.s};
    deltas_.assign(input.camera.size(), {});
    speeds_.assign(input.camera.size(), {});
    guess_gravity(spans);
    for (const Span& span : spans) guess_speed(span);
    add_priors(place);
    for (const Span& span : spans) add_span(span);
    for (const std::size_t i : used(spans)) add_pose(i, i == spans.front().from);
  }

  /// Twice: the first solution says how large the measurements' errors are next to the priors'.
  void solve() {
    solve_once();
    prior_weight_ = std::sqrt(reduced_chi2_);
    solve_once();
  }

  void store(CameraImuCalibration& result) {
    result.T_cam_imu.linear() = R_cam_imu_ * so3_exp({mount_[0], mount_[1], mount_[2]});
    result.T_cam_imu.translation() = Eigen::Vector3d(mount_[3], mount_[4], mount_[5]);
    result.time_offset_s = mount_[6];
    result.gyro_bias_radps = Eigen::Vector3d(bias_[0], bias_[1], bias_[2]);
    result.accelerometer_bias_mps2 = Eigen::Vector3d(bias_[3], bias_[4], bias_[5]);
    result.gravity_ref_mps2 = Eigen::Vector3d(gravity_[0], gravity_[1], gravity_[2]);
    result.reduced_chi2 = reduced_chi2_;
    result.covariance = reduced_chi2_ * unit_covariance(problem_, mount_,
                                                        "the motion does not determine the camera's poses: move more");
    if (!offset_shown_) result.covariance(kImuTimeOffset, kImuTimeOffset) = kSearchS * kSearchS;
  }

 private:
  static std::vector<std::size_t> used(const std::vector<Span>& spans) {
    std::vector<std::size_t> list;
    for (const Span& span : spans) {
      if (list.empty() || list.back() != span.from) list.push_back(span.from);
      list.push_back(span.to);
    }
    return list;
  }

  /// At rest on average, the unit reads nothing but what holds it up.
  void guess_gravity(const std::vector<Span>& spans) {
    Eigen::Vector3d up = Eigen::Vector3d::Zero();
    for (const Span& span : spans) {
      const CameraSample &from = input_.camera[span.from], &to = input_.camera[span.to];
      readings_.walk<double>(from.t_s + mount_[6], to.t_s + mount_[6],
                             [&](double dt, const Eigen::Vector3d&, const Eigen::Vector3d& force) {
                               up += from.T_ref_cam.linear() * (R_cam_imu_ * force) * dt;
                             });
    }
    const Eigen::Vector3d g = -kGravityMps2 * up.normalized();
    gravity_ = {g.x(), g.y(), g.z()};
  }

  void guess_speed(const Span& span) {
    const CameraSample &from = input_.camera[span.from], &to = input_.camera[span.to];
    const Eigen::Vector3d place(mount_[3], mount_[4], mount_[5]);
    const Eigen::Vector3d v = (to.T_ref_cam * place - from.T_ref_cam * place) / (to.t_s - from.t_s);
    for (const std::size_t i : {span.from, span.to}) speeds_[i] = {v.x(), v.y(), v.z()};
  }

  void add_priors(const Eigen::Vector3d& place) {
    Eigen::Matrix<double, 7, 1> mean, deviation;
    mean << 0, 0, 0, place, mount_[6];
    deviation << 1, 1, 1, 0.5, 0.5, 0.5, offset_shown_ ? kSearchS : kHeldS;
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Prior<7>, 7, 7>(new Prior<7>{mean, deviation, prior_weight_}), nullptr,
        mount_.data());
    Vector6d biases;
    biases << 0.1, 0.1, 0.1, 0.5, 0.5, 0.5;
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Prior<6>, 6, 6>(new Prior<6>{Vector6d::Zero(), biases, prior_weight_}), nullptr,
        bias_.data());
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<GravityError, 1, 3>(new GravityError{kGravityMps2, kGravityDeviationMps2}),
        nullptr, gravity_.data());
  }

  void add_span(const Span& span) {
    const CameraSample &from = input_.camera[span.from], &to = input_.camera[span.to];
    const Matrix9d noise = noise_of(readings_, from.t_s + mount_[6], to.t_s + mount_[6], input_);
    auto* error =
        new ImuError{readings_, from.T_ref_cam, to.T_ref_cam, from.t_s, to.t_s, R_cam_imu_, whitening<9>(noise)};
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<ImuError, 9, 7, 6, 3, 6, 3, 6, 3>(error), nullptr,
                              mount_.data(), bias_.data(), gravity_.data(), deltas_[span.from].data(),
                              speeds_[span.from].data(), deltas_[span.to].data(), speeds_[span.to].data());
    if (input_.motion != CameraMotion::kSteps) return;
    auto* step = new StepError{from.T_ref_cam, to.T_ref_cam, whitening<6>(to.covariance)};
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<StepError, 6, 6, 6>(step), new ceres::HuberLoss(kHuber),
                              deltas_[span.from].data(), deltas_[span.to].data());
  }

  /// Steps need a first pose to start from.
  void add_pose(std::size_t i, bool first) {
    const bool steps = input_.motion == CameraMotion::kSteps;
    if (steps && !first) return;
    const Matrix6d W = steps ? Matrix6d(1e6 * Matrix6d::Identity()) : whitening<6>(input_.camera[i].covariance);
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PoseError, 6, 6>(new PoseError{W}),
                              new ceres::HuberLoss(kHuber), deltas_[i].data());
  }

  void solve_once() {
    reduced_chi2_ = calib::solve(problem_, 60, 1e-7, "camera and inertial unit cannot be brought together");
  }

  const CameraImuInput& input_;
  const Readings& readings_;
  bool offset_shown_;
  Eigen::Matrix3d R_cam_imu_;
  std::array<double, 7> mount_{};
  std::array<double, 6> bias_{};
  std::array<double, 3> gravity_{};
  std::vector<std::array<double, 6>> deltas_;
  std::vector<std::array<double, 3>> speeds_;
  double prior_weight_ = 1, reduced_chi2_ = 0;
  ceres::Problem problem_;
};

/// The longest part without a lost step.
CameraImuInput longest_part(const CameraImuInput& input) {
  std::size_t best = 0, length = 0, begin = 0;
  for (std::size_t i = 0; i <= input.camera.size(); ++i) {
    if (i < input.camera.size() && (i == 0 || input.camera[i].linked)) continue;
    if (i - begin > length) best = begin, length = i - begin;
    begin = i;
  }
  CameraImuInput part = input;
  const auto first = input.camera.begin() + static_cast<std::ptrdiff_t>(best);
  part.camera.assign(first, first + static_cast<std::ptrdiff_t>(length));
  return part;
}

void require_common_time(const CameraImuInput& input) {
  if (input.imu.size() < 2 || input.camera.size() < 2) throw InputError("no readings or no camera motion");
  const double ahead_s = input.imu.front().t_s - input.camera.front().t_s;
  if (input.camera.back().t_s >= input.imu.front().t_s - kSearchS &&
      input.camera.front().t_s <= input.imu.back().t_s + kSearchS)
    return;
  throw InputError(fmt::format(
      "clocks apart: camera and inertial unit have no moment in common (the unit's first time is {:.3f} s after the "
      "camera's)",
      ahead_s));
}

void require_motion(const CameraImuInput& input, const std::vector<Span>& spans, CameraImuCalibration& result) {
  for (const Span& span : spans) {
    const CameraSample &from = input.camera[span.from], &to = input.camera[span.to];
    result.duration_s += to.t_s - from.t_s;
    result.turned_rad += turn_of(from, to).norm();
  }
  result.steps = spans.size();
  if (result.duration_s < kLeastDurationS) {
    throw InputError(
        fmt::format("{:.1f} s with camera and readings at the same time: too short, or the clocks are "
                    "apart; thirty seconds are good",
                    result.duration_s));
  }
  if (result.turned_rad < kLeastTurnedRad) {
    throw InputError(fmt::format(
        "no turning to speak of ({:.1f} rad): turn about all three axes, fast but without blur", result.turned_rad));
  }
}

std::string axis_text(const Eigen::Vector3d& axis) {
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", axis.x(), axis.y(), axis.z());
}

}  // namespace

double CameraImuCalibration::worst_deviation(int first, Eigen::Vector3d* axis) const {
  const Eigen::Matrix3d block = covariance.block<3, 3>(first, first);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(block);
  if (axis != nullptr) *axis = eigen.eigenvectors().col(2);
  return std::sqrt(eigen.eigenvalues()[2]);
}

bool CameraImuCalibration::rotation_observed() const {
  return worst_deviation(kMountTurn) <= kTurnWorth;
}
bool CameraImuCalibration::place_observed() const {
  return worst_deviation(kMountPlace) <= kPlaceWorthM;
}
bool CameraImuCalibration::time_offset_observed() const {
  return deviation(kImuTimeOffset) <= kOffsetWorthS;
}

CameraImuCalibration calibrate_camera_imu(const CameraImuInput& given) {
  require_common_time(given);
  const CameraImuInput input = given.motion == CameraMotion::kSteps ? longest_part(given) : given;
  const Readings readings(input.imu);
  CameraImuCalibration result;
  // A camera at rest correlates with nothing: its own sentence comes first.
  require_motion(input, spans_of(input.camera, readings, 0), result);
  const Offset offset = search_offset(readings, input.camera);
  const std::vector<Span> spans = spans_of(input.camera, readings, offset.s);
  result = {};
  require_motion(input, spans, result);
  CameraImuProblem problem(input, readings, spans, offset);
  problem.solve();
  problem.store(result);
  return result;
}

std::vector<std::string> unobserved(const CameraImuCalibration& found) {
  std::vector<std::string> sentences;
  Eigen::Vector3d axis;
  const double turn = found.worst_deviation(kMountTurn, &axis);
  if (!found.rotation_observed()) {
    sentences.push_back(
        fmt::format("the rotation about the unit's axis {} is known to +- {:.2g} deg only: turn about two more axes",
                    axis_text(axis), kConfidence * turn * 180 / M_PI));
  }
  const double place_m = found.worst_deviation(kMountPlace, &axis);
  if (!found.place_observed()) {
    sentences.push_back(fmt::format(
        "the distance along the camera's axis {} is known to +- {:.2g} mm only: turn faster, about other axes too, or "
        "measure it by hand",
        axis_text(axis), kConfidence * 1e3 * place_m));
  }
  if (!found.time_offset_observed()) {
    sentences.push_back(fmt::format("the clocks' offset is known to +- {:.2g} ms only: start and end turns often",
                                    kConfidence * 1e3 * found.deviation(kImuTimeOffset)));
  }
  return sentences;
}

}  // namespace arpent::calib
