// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/drive.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/error.h"
#include "common/pose2.h"

namespace arpent::calib {
namespace {

constexpr double kLeastDrivenM = 2, kLeastTurnedRad = 6;
constexpr double kSearchS = 0.5, kSearchStepS = 0.01;
constexpr double kLeastCorrelation = 0.7;
constexpr double kMostGapS = 1;
/// Noise of the wheels: encoder steps, slip along and across the way, per root metre.
constexpr double kEncoderM = 5e-4, kSlipRootM = 0.002;
constexpr double kHuber = 3;

double scalar(double x) {
  return x;
}
template <class T, int N>
double scalar(const ceres::Jet<T, N>& x) {
  return x.a;
}

template <class T>
using Planar = std::array<T, 3>;  ///< x, y [m], yaw [rad]

template <class T>
Planar<T> compose(const Planar<T>& a, const Planar<T>& b) {
  using std::cos;
  using std::sin;
  const T c = cos(a[2]), s = sin(a[2]);
  return {a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]};
}
template <class T>
Planar<T> inverse(const Planar<T>& a) {
  using std::cos;
  using std::sin;
  const T c = cos(a[2]), s = sin(a[2]);
  return {-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]};
}
Planar<double> planar(const Pose& T) {
  const Pose2 p = to_pose2(T);
  return {p.x_m, p.y_m, p.yaw_rad};
}

class Ways {
 public:
  explicit Ways(const std::vector<WheelWays>& samples) : samples_(samples) {}

  [[nodiscard]] bool covers(double from_s, double to_s) const {
    if (from_s < samples_.front().t_s || to_s >= samples_.back().t_s) return false;
    for (std::size_t i = after(from_s); i < samples_.size() && samples_[i - 1].t_s < to_s; ++i) {
      if (samples_[i].t_s - samples_[i - 1].t_s > 0.2) return false;
    }
    return true;
  }

  /// (left, right) by the cubic B-spline over the samples; differentiable by the time. It evens out the encoders'
  /// counts alike at and between samples; a straight line does so only in between, and draws the delay there.
  template <class T>
  std::array<T, 2> at(const T& t_s) const {
    const std::size_t i = std::clamp<std::size_t>(after(scalar(t_s)), 1, samples_.size() - 1);
    const double period_s = samples_[i].t_s - samples_[i - 1].t_s;
    const T u = (t_s - samples_[i - 1].t_s) / period_s, v = 1.0 - u;
    const std::array<T, 4> weight{v * v * v / 6.0, (3.0 * u * u * (u - 2.0) + 4.0) / 6.0,
                                  (3.0 * v * v * (v - 2.0) + 4.0) / 6.0, u * u * u / 6.0};
    T left(0), right(0), time_s(0);
    for (std::size_t k = 0; k < weight.size(); ++k) {
      const std::size_t j = std::clamp<std::size_t>(i + k, 2, samples_.size() + 1) - 2;
      left += weight[k] * samples_[j].left_m;
      right += weight[k] * samples_[j].right_m;
      time_s += weight[k] * (samples_[j].t_s - samples_[i - 1].t_s);
    }
    // Where samples are not evenly spaced, the spline's time is not quite the one asked for.
    const T late = (t_s - samples_[i - 1].t_s - time_s) / period_s;
    return {left + late * (samples_[i].left_m - samples_[i - 1].left_m),
            right + late * (samples_[i].right_m - samples_[i - 1].right_m)};
  }

  /// Motion of the body between two times: arcs from sample to sample.
  template <class T>
  Planar<T> step(const T& from_s, const T& to_s, const T* q) const {
    Planar<T> pose{T(0), T(0), T(0)};
    std::array<T, 2> last = at(from_s);
    const auto go = [&](const std::array<T, 2>& next) {
      using std::cos;
      using std::sin;
      const T left = q[kLeftScale] * (next[0] - last[0]), right = q[kRightScale] * (next[1] - last[1]);
      const T way = 0.5 * (left + right), turn = (right - left) / q[kTrack];
      const T heading = pose[2] + 0.5 * turn;
      const T chord = way * (1.0 - turn * turn / 24.0);
      pose = {pose[0] + chord * cos(heading), pose[1] + chord * sin(heading), pose[2] + turn};
      last = next;
    };
    for (std::size_t i = after(scalar(from_s)); i < samples_.size() && samples_[i].t_s < scalar(to_s); ++i) {
      go(at(T(samples_[i].t_s)));
    }
    go(at(to_s));
    return pose;
  }

 private:
  [[nodiscard]] std::size_t after(double t_s) const {
    return static_cast<std::size_t>(std::upper_bound(samples_.begin(), samples_.end(), t_s,
                                                     [](double t, const WheelWays& w) { return t < w.t_s; }) -
                                    samples_.begin());
  }
  const std::vector<WheelWays>& samples_;
};

/// Two camera poses with wheels in between.
struct Span {
  std::size_t from, to;
  double from_s, to_s;
  Planar<double> seen;         ///< the step, by the filed mounting
  Eigen::Matrix3d covariance;  ///< of the camera's step; for poses unused
  Eigen::Matrix3d wheels;      ///< of the wheels' step, body axes
};

Eigen::Matrix3d wheel_covariance(const Planar<double>& step, double track_m) {
  const double way_m = std::hypot(step[0], step[1]) + 0.5 * track_m * std::abs(step[2]);
  const double side2 = 2 * kEncoderM * kEncoderM + kSlipRootM * kSlipRootM * way_m;
  return Eigen::Vector3d(0.5 * side2, 0.5 * side2, 2 * side2 / (track_m * track_m)).asDiagonal();
}

Eigen::Matrix3d whitening(const Eigen::Matrix3d& covariance) {
  const Eigen::LLT<Eigen::Matrix3d> llt(covariance);
  if (llt.info() != Eigen::Success) throw InputError("a covariance of the camera's motion is not positive");
  return llt.matrixL().solve(Eigen::Matrix3d::Identity());
}

template <class T>
void whiten(const Eigen::Matrix3d& W, const Planar<T>& error, T* residual) {
  for (int r = 0; r < 3; ++r) {
    residual[r] = T(0);
    for (int c = 0; c <= r; ++c) residual[r] += W(r, c) * error[static_cast<std::size_t>(c)];
  }
}

/// A step of the camera's odometry against the wheels.
struct StepError {
  const Ways& ways;
  Span span;
  Eigen::Matrix3d W;
  template <class T>
  bool operator()(const T* q, T* residual) const {
    const Planar<T> mount{q[kMountX], q[kMountY], q[kMountYaw]};
    const Planar<T> step = ways.step<T>(span.from_s + q[kTimeOffset], span.to_s + q[kTimeOffset], q);
    const Planar<T> expected = compose(compose(inverse(mount), step), mount);
    whiten(W, {expected[0] - span.seen[0], expected[1] - span.seen[1], expected[2] - span.seen[2]}, residual);
    return true;
  }
};

/// The wheels between two poses of the body.
struct WheelError {
  const Ways& ways;
  Span span;
  Eigen::Matrix3d W;
  template <class T>
  bool operator()(const T* q, const T* from, const T* to, T* residual) const {
    const Planar<T> step = ways.step<T>(span.from_s + q[kTimeOffset], span.to_s + q[kTimeOffset], q);
    const Planar<T> moved = compose(inverse(Planar<T>{from[0], from[1], from[2]}), Planar<T>{to[0], to[1], to[2]});
    whiten(W, {moved[0] - step[0], moved[1] - step[1], moved[2] - step[2]}, residual);
    return true;
  }
};

/// A pose that the camera sees, against the body's.
struct PoseError {
  Planar<double> seen;
  Eigen::Matrix3d W;
  template <class T>
  bool operator()(const T* q, const T* pose, T* residual) const {
    const Planar<T> mount{q[kMountX], q[kMountY], q[kMountYaw]};
    const Planar<T> filed = compose(Planar<T>{pose[0], pose[1], pose[2]}, mount);
    Planar<T> error = compose(inverse(Planar<T>{T(seen[0]), T(seen[1]), T(seen[2])}), filed);
    error[2] -= 2 * M_PI * std::round(scalar(error[2]) / (2 * M_PI));
    whiten(W, error, residual);
    return true;
  }
};

double turn_of_ways(const Ways& ways, double from_s, double to_s) {
  const auto a = ways.at(from_s), b = ways.at(to_s);
  return (b[1] - a[1]) - (b[0] - a[0]);
}

/// The shift at which the wheels turn as the camera does.
double search_offset(const Ways& ways, const std::vector<CameraPose>& camera) {
  double best = 0, best_s = 0;
  for (int k = -std::lround(kSearchS / kSearchStepS); k <= std::lround(kSearchS / kSearchStepS); ++k) {
    double ab = 0, aa = 0, bb = 0;
    for (std::size_t i = 1; i < camera.size(); ++i) {
      const double from_s = camera[i - 1].t_s + k * kSearchStepS, to_s = camera[i].t_s + k * kSearchStepS;
      if (to_s - from_s > kMostGapS || !ways.covers(from_s, to_s)) continue;
      const double a = planar(camera[i - 1].T_ref_body.inverse() * camera[i].T_ref_body)[2];
      const double b = turn_of_ways(ways, from_s, to_s);
      ab += a * b, aa += a * a, bb += b * b;
    }
    const double correlation = aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
    if (std::abs(correlation) > std::abs(best)) best = correlation, best_s = k * kSearchStepS;
  }
  if (best < -kLeastCorrelation) {
    throw InputError("the wheels turn against the camera: left and right are swapped, or both have the wrong sign");
  }
  if (best < kLeastCorrelation) {
    throw InputError(
        fmt::format("wheels and camera do not turn together (correlation {:.2f}): clocks apart by more than {} s, one "
                    "side with a wrong sign, or channels of different robots",
                    best, kSearchS));
  }
  return best_s;
}

std::vector<Span> spans_of(const DriveInput& input, const Ways& ways, double offset_s) {
  constexpr double kMarginS = 0.05;  // that the offset may still move
  std::vector<Span> spans;
  const std::array<double, kDriveParameters> q{1, 1, input.track_m, 0, 0, 0, 0};
  for (std::size_t i = 1; i < input.camera.size(); ++i) {
    const CameraPose &a = input.camera[i - 1], &b = input.camera[i];
    if (b.t_s - a.t_s > kMostGapS || !ways.covers(a.t_s + offset_s - kMarginS, b.t_s + offset_s + kMarginS)) continue;
    Span span{i - 1, i, a.t_s, b.t_s, planar(a.T_ref_body.inverse() * b.T_ref_body), b.covariance, {}};
    span.wheels = wheel_covariance(ways.step(a.t_s + offset_s, b.t_s + offset_s, q.data()), input.track_m);
    spans.push_back(span);
  }
  return spans;
}

void require_motion(const std::vector<Span>& spans, DriveCalibration& result) {
  for (const Span& span : spans) {
    result.driven_m += std::hypot(span.seen[0], span.seen[1]);
    result.turned_rad += std::abs(span.seen[2]);
  }
  if (spans.size() < 30) {
    throw InputError(fmt::format("{} steps with wheels and camera at the same time: too short, or the clocks are apart",
                                 spans.size()));
  }
  if (result.driven_m < kLeastDrivenM) {
    throw InputError(fmt::format("no motion to speak of: {:.1f} m; drive at least {} m, with turns to both sides",
                                 result.driven_m, kLeastDrivenM));
  }
  if (result.turned_rad < kLeastTurnedRad) {
    throw InputError(
        fmt::format("too little turning ({:.1f} rad) to tell the track and the camera's place: turn to "
                    "both sides, {} rad and more",
                    result.turned_rad, kLeastTurnedRad));
  }
}

/// Roll and pitch of the filed body: where its axes see the vertical of the fixed frame, on average over the headings.
void add_tilt(const std::vector<CameraPose>& camera, DriveCalibration& result) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const CameraPose& pose : camera) up += pose.T_ref_body.linear().row(2).transpose();
  up.normalize();
  double squares = 0;
  for (const CameraPose& pose : camera) squares += (pose.T_ref_body.linear().row(2).transpose() - up).squaredNorm();
  const auto n = static_cast<double>(camera.size());
  const double pitch = -std::asin(up.x()), roll = std::atan2(up.y(), up.z());
  result.T_body_filed.linear() = result.T_body_filed.linear() * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
  result.tilt_observed = true;
  result.tilt_deviation_rad = std::sqrt(0.5 * squares / (n * (n - 1)));
}

}  // namespace

DriveCalibration calibrate_drive(const DriveInput& input) {
  ARPENT_ASSERT(input.track_m > 0);
  if (input.wheels.size() < 2 || input.camera.size() < 2) throw InputError("no wheels or no camera motion");
  const Ways ways(input.wheels);
  const auto& w = input.wheels;
  if (input.camera.back().t_s < w.front().t_s - kSearchS || input.camera.front().t_s > w.back().t_s + kSearchS) {
    throw InputError("clocks apart: wheels and camera have no moment in common");
  }
  DriveCalibration result;
  // A drive without motion or turns correlates with nothing: its own sentence comes first.
  require_motion(spans_of(input, ways, 0), result);
  const double offset_s = search_offset(ways, input.camera);
  const std::vector<Span> spans = spans_of(input, ways, offset_s);
  result = {};
  require_motion(spans, result);

  std::array<double, kDriveParameters> q{1, 1, input.track_m, offset_s, 0, 0, 0};
  std::vector<Planar<double>> poses;
  for (const CameraPose& pose : input.camera) {
    poses.push_back(planar(pose.T_ref_body));
    if (poses.size() < 2) continue;
    // Headings go on beyond half a turn, as the wheels' do.
    const double before = poses[poses.size() - 2][2];
    poses.back()[2] = before + wrap_angle(poses.back()[2] - before);
  }
  ceres::Problem problem;
  auto* loss = new ceres::HuberLoss(kHuber);
  std::vector<bool> seen(poses.size(), false);
  for (const Span& span : spans) {
    if (input.motion == CameraMotion::kSteps) {
      auto* error = new StepError{ways, span, whitening(span.covariance + span.wheels)};
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<StepError, 3, kDriveParameters>(error), loss, q.data());
      continue;
    }
    auto* error = new WheelError{ways, span, whitening(span.wheels)};
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<WheelError, 3, kDriveParameters, 3, 3>(error), loss,
                             q.data(), poses[span.from].data(), poses[span.to].data());
    for (const std::size_t i : {span.from, span.to}) {
      if (seen[i]) continue;
      seen[i] = true;
      auto* pose = new PoseError{planar(input.camera[i].T_ref_body), whitening(input.camera[i].covariance)};
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PoseError, 3, kDriveParameters, 3>(pose), loss, q.data(),
                               poses[i].data());
    }
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-10;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  const int dof = problem.NumResiduals() - problem.NumParameters();
  if (!summary.IsSolutionUsable() || dof < 1) throw InputError("wheels and camera cannot be brought together");
  result.reduced_chi2 = 2 * summary.final_cost / dof;
  ceres::Covariance::Options how;
  how.algorithm_type = ceres::SPARSE_QR;
  how.num_threads = 1;
  ceres::Covariance covariance(how);
  Eigen::Matrix<double, kDriveParameters, kDriveParameters, Eigen::RowMajor> C;
  const std::vector<std::pair<const double*, const double*>> blocks{{q.data(), q.data()}};
  if (!covariance.Compute(blocks, &problem) || !covariance.GetCovarianceBlock(q.data(), q.data(), C.data())) {
    throw InputError("the drive does not determine all of scales, track and mounting: turn to both sides and drive on");
  }
  result.covariance = result.reduced_chi2 * C;
  result.left_scale = q[kLeftScale];
  result.right_scale = q[kRightScale];
  result.track_m = q[kTrack];
  result.time_offset_s = q[kTimeOffset];
  result.T_body_filed = Pose2{q[kMountX], q[kMountY], q[kMountYaw]}.to_pose();
  result.steps = spans.size();
  if (result.left_scale < 0.2 || result.right_scale < 0.2 || result.track_m < 0.02) {
    throw InputError(
        fmt::format("wheels say nonsense (scales {:.2f} and {:.2f}, track {:.2f} m): one side has the wrong "
                    "sign, or the channels are mixed up",
                    result.left_scale, result.right_scale, result.track_m));
  }
  if (input.motion == CameraMotion::kPoses) add_tilt(input.camera, result);
  return result;
}

}  // namespace arpent::calib
