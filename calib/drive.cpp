// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/drive.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/drive_errors.h"
#include "calib/least_squares.h"
#include "common/error.h"
#include "common/pose2.h"

namespace arpent::calib {
namespace {

using namespace drive;

constexpr double kLeastDrivenM = 2, kLeastTurnedRad = 6;
constexpr double kSearchS = 0.5, kSearchStepS = 0.01;
/// Holds an offset that the drive does not show where it is.
constexpr double kHeldS = 1e-6;
constexpr double kLeastCorrelation = 0.7;
constexpr double kMostGapS = 1.5;
/// Noise of the wheels: encoder steps, slip along and across the way, per root metre.
constexpr double kEncoderM = 5e-4, kSlipRootM = 0.002;
constexpr double kHuber = 3;
/// Share by which a scale or a track may be wrong at first.
constexpr double kThinkableScale = 0.3;

Eigen::Matrix3d wheel_covariance(const Planar<double>& step, double track_m) {
  const double way_m = std::hypot(step[0], step[1]) + 0.5 * track_m * std::abs(step[2]);
  const double side2 = 2 * kEncoderM * kEncoderM + kSlipRootM * kSlipRootM * way_m;
  return Eigen::Vector3d(0.5 * side2, 0.5 * side2, 2 * side2 / (track_m * track_m)).asDiagonal();
}

double turn_of_ways(const Ways& ways, double from_s, double to_s) {
  const auto a = ways.at(from_s), b = ways.at(to_s);
  return (b[1] - a[1]) - (b[0] - a[0]);
}

/// How alike wheels and camera turn if the wheels' clock is `offset_s` ahead.
double correlation(const Ways& ways, const std::vector<CameraPose>& camera, double offset_s) {
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 1; i < camera.size(); ++i) {
    const double from_s = camera[i - 1].t_s + offset_s, to_s = camera[i].t_s + offset_s;
    if (!camera[i].linked || to_s - from_s > kMostGapS || !ways.covers(from_s, to_s)) continue;
    const double a = planar(camera[i - 1].T_ref_body.inverse() * camera[i].T_ref_body)[2];
    const double b = turn_of_ways(ways, from_s, to_s);
    ab += a * b, aa += a * a, bb += b * b;
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

struct Offset {
  double s = 0;
  /// Whether other offsets are any worse. On a circle at steady speed none is, and the noise of the encoders alone
  /// would draw the estimate somewhere, with a small deviation.
  bool shown = false;
};

/// The offset at which the wheels turn as the camera does.
Offset search_offset(const Ways& ways, const std::vector<CameraPose>& camera) {
  constexpr double kAsideS = 0.2, kLeastDrop = 0.01;
  double best = 0, best_s = 0;
  for (int k = -std::lround(kSearchS / kSearchStepS); k <= std::lround(kSearchS / kSearchStepS); ++k) {
    const double here = correlation(ways, camera, k * kSearchStepS);
    if (std::abs(here) > std::abs(best)) best = here, best_s = k * kSearchStepS;
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
  const double aside =
      std::max(correlation(ways, camera, best_s - kAsideS), correlation(ways, camera, best_s + kAsideS));
  if (best - aside < kLeastDrop) return {};
  return {best_s, true};
}

std::vector<Span> spans_of(const DriveInput& input, const Ways& ways, double offset_s) {
  constexpr double kMarginS = 0.05;  // that the offset may still move
  std::vector<Span> spans;
  const std::array<double, kDriveParameters> q{1, 1, input.track_m, 0, 0, 0, 0, 1};
  for (std::size_t i = 1; i < input.camera.size(); ++i) {
    const CameraPose &a = input.camera[i - 1], &b = input.camera[i];
    if (!b.linked || b.t_s - a.t_s > kMostGapS) continue;
    if (!ways.covers(a.t_s + offset_s - kMarginS, b.t_s + offset_s + kMarginS)) continue;
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

/// The least squares problem over the drive's parameters and, for poses, the body's pose at each of them.
class DriveProblem {
 public:
  DriveProblem(const DriveInput& input, const Ways& ways, const std::vector<Span>& spans, const Offset& offset)
      : q_{1, 1, input.track_m, offset.s, 0, 0, 0, 1}, offset_shown_(offset.shown) {
    unwrap(input.camera);
    auto* prior = new PriorError{q_,
                                 {kThinkableScale, kThinkableScale, kThinkableScale * input.track_m,
                                  offset.shown ? kSearchS : kHeldS, 1, 1, 1, input.step_scale_deviation},
                                 prior_weight_};
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PriorError, kDriveParameters, kDriveParameters>(prior),
                              nullptr, q_.data());
    auto* loss = new ceres::HuberLoss(kHuber);
    for (const Span& span : spans)
      input.motion == CameraMotion::kSteps ? add_step(ways, span, loss) : add_wheels(input, ways, span, loss);
  }

  /// Twice: the first solution says how large the measurements' errors are next to the priors'.
  void solve() {
    solve_once();
    prior_weight_ = std::sqrt(reduced_chi2_);
    solve_once();
  }

  void store(DriveCalibration& result) {
    result.reduced_chi2 = reduced_chi2_;
    result.covariance =
        reduced_chi2_ *
        unit_covariance(problem_, q_,
                        "the drive does not determine the body's poses: drive on, with turns to both sides");
    if (!offset_shown_) result.covariance(kTimeOffset, kTimeOffset) = kSearchS * kSearchS;
    result.left_scale = q_[kLeftScale];
    result.right_scale = q_[kRightScale];
    result.track_m = q_[kTrack];
    result.time_offset_s = q_[kTimeOffset];
    result.T_body_filed = Pose2{q_[kMountX], q_[kMountY], q_[kMountYaw]}.to_pose();
    result.step_scale = q_[kStepScale];
  }

 private:
  using Parameters = std::array<double, kDriveParameters>;

  /// Headings go on beyond half a turn, as the wheels' do.
  void unwrap(const std::vector<CameraPose>& camera) {
    for (const CameraPose& pose : camera) {
      poses_.push_back(planar(pose.T_ref_body));
      if (poses_.size() < 2) continue;
      const double before = poses_[poses_.size() - 2][2];
      poses_.back()[2] = before + wrap_angle(poses_.back()[2] - before);
    }
    seen_.assign(poses_.size(), false);
  }

  void add_step(const Ways& ways, const Span& span, ceres::LossFunction* loss) {
    auto* error = new StepError{ways, span, whitening<3>(span.covariance + span.wheels)};
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<StepError, 3, kDriveParameters>(error), loss, q_.data());
  }

  void add_wheels(const DriveInput& input, const Ways& ways, const Span& span, ceres::LossFunction* loss) {
    auto* error = new WheelError{ways, span, whitening<3>(span.wheels)};
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<WheelError, 3, kDriveParameters, 3, 3>(error), loss,
                              q_.data(), poses_[span.from].data(), poses_[span.to].data());
    for (const std::size_t i : {span.from, span.to}) {
      if (seen_[i]) continue;
      seen_[i] = true;
      auto* pose = new PoseError{planar(input.camera[i].T_ref_body), whitening<3>(input.camera[i].covariance)};
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PoseError, 3, kDriveParameters, 3>(pose), loss,
                                q_.data(), poses_[i].data());
    }
  }

  void solve_once() {
    reduced_chi2_ = calib::solve(problem_, 100, 1e-10, "wheels and camera cannot be brought together");
  }

  Parameters q_;
  bool offset_shown_;
  double prior_weight_ = 1, reduced_chi2_ = 0;
  std::vector<Planar<double>> poses_;
  std::vector<bool> seen_;
  ceres::Problem problem_;
};

void require_common_time(const DriveInput& input) {
  if (input.wheels.size() < 2 || input.camera.size() < 2) throw InputError("no wheels or no camera motion");
  const auto& w = input.wheels;
  const auto& c = input.camera;
  if (c.back().t_s < w.front().t_s - kSearchS || c.front().t_s > w.back().t_s + kSearchS) {
    throw InputError(
        fmt::format("clocks apart: wheels and camera have no moment in common (the wheels' first time is {:.3f} s "
                    "after the camera's)",
                    w.front().t_s - c.front().t_s));
  }
}

void require_sense(const DriveCalibration& found) {
  if (found.left_scale >= 0.2 && found.right_scale >= 0.2 && found.track_m >= 0.02) return;
  throw InputError(
      fmt::format("wheels say nonsense (scales {:.2f} and {:.2f}, track {:.2f} m): one side has the wrong "
                  "sign, or the channels are mixed up",
                  found.left_scale, found.right_scale, found.track_m));
}

/// Deviations beyond which a parameter is not worth having.
double worth_having(const DriveCalibration& found, DriveParameter parameter) {
  switch (parameter) {
    case kLeftScale:
    case kRightScale:
      return 0.02;
    case kTrack:
      return 0.02 * found.track_m;
    case kTimeOffset:
      return 0.01;
    case kMountX:
    case kMountY:
      return 0.02;
    default:
      return 0.01;
  }
}

}  // namespace

bool DriveCalibration::observed(DriveParameter parameter) const {
  return deviation(parameter) <= worth_having(*this, parameter);
}

DriveCalibration calibrate_drive(const DriveInput& input) {
  ARPENT_ASSERT(input.track_m > 0);
  require_common_time(input);
  const Ways ways(input.wheels);
  DriveCalibration result;
  // A drive without motion or turns correlates with nothing: its own sentence comes first.
  require_motion(spans_of(input, ways, 0), result);
  const Offset offset = search_offset(ways, input.camera);
  const std::vector<Span> spans = spans_of(input, ways, offset.s);
  result = {};
  require_motion(spans, result);
  DriveProblem problem(input, ways, spans, offset);
  problem.solve();
  problem.store(result);
  result.steps = spans.size();
  require_sense(result);
  if (input.motion == CameraMotion::kPoses && input.tilt_measured) add_tilt(input.camera, result);
  return result;
}

std::vector<std::string> unobserved(const DriveCalibration& found) {
  std::vector<std::string> sentences;
  const auto say = [&](DriveParameter parameter, const std::string& what, double unit, const char* remedy) {
    if (found.observed(parameter)) return;
    sentences.push_back(fmt::format("{} is known to +- {:.3g} only, and stays as it was: {}", what,
                                    kConfidence * unit * found.deviation(parameter), remedy));
  };
  say(kLeftScale, "the left scale [%]", 100, "drive further");
  say(kRightScale, "the right scale [%]", 100, "drive further");
  say(kTrack, "the track [mm]", 1000, "turn more, to both sides");
  say(kTimeOffset, "the clocks' offset [ms]", 1000, "start and end turns often, do not drive in one circle");
  say(kMountX, "the camera's place ahead [mm]", 1000, "turn more, also on the spot");
  say(kMountY, "the camera's place to the side [mm]", 1000, "turn more, also on the spot");
  say(kMountYaw, "the camera's heading [deg]", 180 / M_PI, "drive straight ways between the turns");
  if (!found.tilt_observed) {
    sentences.emplace_back("roll and pitch of the camera are not in the motion: tags of a known cube show them");
  }
  sentences.emplace_back("the height of the camera is not in a motion on level ground: measure it by hand");
  return sentences;
}

}  // namespace arpent::calib
