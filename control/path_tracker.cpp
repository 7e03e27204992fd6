// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "control/path_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <numbers>

#include "common/config/config.h"
#include "common/pose2.h"
#include "control/box_qp.h"

namespace arpent::control {
namespace {

constexpr int kSteps = 15;
constexpr double kStepS = 0.1;
constexpr int kInputs = 2 * kSteps;  // speed and turn rate of each step, alternating
constexpr int kErrors = 5;           // along, across, heading, speed, turn rate
constexpr int kQpIterations = 30;
/// More than this beyond a bound means that the solver did not converge (commands are held to the limits anyway).
constexpr double kMaxViolation = 0.1;
// Weights of squared errors (per m, m, rad, m/s, rad/s) and of squared inputs.
const Eigen::Matrix<double, kErrors, 1> kErrorWeights(4, 120, 12, 10, 0.3);
constexpr double kSpeedWeight = 1;
constexpr double kTurnWeight = 0.3;
constexpr double kSpeedChangeWeight = 8;
constexpr double kTurnChangeWeight = 1.5;

constexpr double kSearchBackM = 0.3;
constexpr double kSearchAheadM = 1.0;
constexpr double kArrivedM = 0.02;
constexpr double kTurnFirstRad = 1.0;           // a path that begins more than this aside is turned to on the spot,
constexpr double kTurnFirstStandingRad = 0.35;  // by a base that stands: it loses nothing
constexpr double kTurnedRad = 0.08;             // good enough to set off
constexpr double kAtHeadingRad = 0.02;          // good enough to have arrived
constexpr double kTurnGainPerS = 2.5;
constexpr double kStandMps = 0.02;
constexpr double kStandRadps = 0.05;
constexpr double kIntegrationStepS = 0.01;

using Errors = Eigen::Matrix<double, kErrors, 1>;
using Inputs = Eigen::Matrix<double, kInputs, 1>;
using Qp = BoxQp<kInputs, 2 * kInputs>;

bool finite(const BaseState& s) {
  return s.p_map_m.allFinite() && std::isfinite(s.yaw_rad) && std::isfinite(s.twist.speed_mps) &&
         std::isfinite(s.twist.turn_rate_radps);
}

/// The reference over the horizon: at each step the speed at its begin and the path's curvature.
struct Reference {
  std::array<double, kSteps> speed_mps{}, curvature_1pm{};
};

Reference make_reference(const Path& path, double s, double speed_now, double max_acceleration) {
  Reference r;
  double speed = speed_now;
  for (std::size_t k = 0; k < kSteps; ++k) {
    const PathPoint here = path.at(s);
    speed = std::min(std::max(here.speed_mps, 0.0), speed + max_acceleration * kStepS);
    // Half a step ahead, so that braking begins in time.
    speed = std::min(speed, std::max(path.at(s + 0.5 * speed * kStepS).speed_mps, 0.0));
    const double next = std::min(s + speed * kStepS, path.length_m());
    r.speed_mps[k] = speed;
    r.curvature_1pm[k] = path.at(0.5 * (s + next)).curvature_1pm;
    s = next;
  }
  return r;
}

/// Errors of the whole horizon as an affine function of the inputs, and with them the quadratic program. `start`:
/// errors now; `last`: the command before the first input. Across and heading are those to the path's nearest point,
/// which moves as the base does (de Luca, Oriolo, Samson, "Feedback control of a nonholonomic car-like robot", 1998):
/// e' = v sin(heading), heading' = turn rate - curvature v. Were they taken to the moving reference,
/// falling behind in a bend would seem to bring the base nearer to the path, and one that starts beside it would stand.
Qp make_qp(const Reference& reference, const Errors& start, const Twist2& last, const TrackerParams& p) {
  const double keep = p.lag_s > 0 ? std::exp(-kStepS / p.lag_s) : 0.0;
  Qp qp;
  qp.H.setZero();
  qp.f.setZero();
  Eigen::Matrix<double, kErrors, kInputs> B = Eigen::Matrix<double, kErrors, kInputs>::Zero();
  Errors x = start;
  for (int k = 0; k < kSteps; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double v = reference.speed_mps[at], w = v * reference.curvature_1pm[at];
    // Speeds follow their command with a lag; positions integrate the mean of both ends.
    Eigen::Matrix<double, kErrors, kErrors> A = Eigen::Matrix<double, kErrors, kErrors>::Identity();
    const double own = 0.5 * (1 + keep) * kStepS, of_input = 0.5 * (1 - keep) * kStepS;
    const double bend = reference.curvature_1pm[at];
    A(0, 3) = own;
    A(1, 2) = v * kStepS;
    A(1, 3) = -0.5 * v * kStepS * bend * own;
    A(1, 4) = 0.5 * v * kStepS * own;
    A(2, 3) = -bend * own;
    A(2, 4) = own;
    A(3, 3) = keep;
    A(4, 4) = keep;
    B = (A * B).eval();
    B(0, 2 * k) += of_input;
    B(1, 2 * k) -= 0.5 * v * kStepS * bend * of_input;
    B(1, 2 * k + 1) += 0.5 * v * kStepS * of_input;
    B(2, 2 * k) -= bend * of_input;
    B(2, 2 * k + 1) += of_input;
    B(3, 2 * k) += 1 - keep;
    B(4, 2 * k + 1) += 1 - keep;
    x = (A * x).eval();
    x(0) -= v * kStepS;
    Errors wanted = Errors::Zero();
    wanted(3) = v;
    wanted(4) = w;
    const int used = 2 * (k + 1);
    const Eigen::Matrix<double, kErrors, kInputs> weighted = kErrorWeights.asDiagonal() * B;
    qp.H.topLeftCorner(used, used).noalias() += B.leftCols(used).transpose() * weighted.leftCols(used);
    qp.f.head(used).noalias() += weighted.leftCols(used).transpose() * (x - wanted);
  }
  qp.C.setZero();
  qp.C.topRows<kInputs>().setIdentity();
  for (int i = 0; i < kInputs; ++i) {
    const bool turn = i % 2 == 1;
    const auto k = static_cast<std::size_t>(i / 2);
    const double wanted = reference.speed_mps[k] * (turn ? reference.curvature_1pm[k] : 1.0);
    const double weight = turn ? kTurnWeight : kSpeedWeight;
    qp.H(i, i) += weight;
    qp.f(i) -= weight * wanted;
    const double most = turn ? p.limits.max_turn_rate_radps : p.limits.max_speed_mps;
    qp.low(i) = turn ? -most : 0.0;
    qp.high(i) = most;
    // Changes, from the last command on.
    const double change = turn ? kTurnChangeWeight : kSpeedChangeWeight;
    const double rate = (turn ? p.limits.max_turn_acceleration_radps2 : p.limits.max_acceleration_mps2) *
                        (k == 0 ? p.period_s : kStepS);
    const int row = kInputs + i;
    const double before = k > 0 ? 0.0 : turn ? last.turn_rate_radps : last.speed_mps;
    qp.C(row, i) = 1;
    qp.low(row) = before - rate;
    qp.high(row) = before + rate;
    qp.H(i, i) += change;
    qp.f(i) -= change * before;
    if (k == 0) continue;
    qp.C(row, i - 2) = -1;
    qp.H(i - 2, i - 2) += change;
    qp.H(i, i - 2) -= change;
    qp.H(i - 2, i) -= change;
  }
  return qp;
}

}  // namespace

/// Driven backwards, a base is one that looks the other way and drives forwards: everything in here is about that one.
struct PathTracker::State {
  TrackerParams params;
  std::optional<Path> path;
  bool backwards = false;
  std::optional<double> goal_heading_rad;
  TrackerMode mode = TrackerMode::kIdle;
  double s_m = 0;
  Twist2 last;
  Inputs plan = Inputs::Zero();
  std::deque<std::pair<Time, Twist2>> sent;

  void look(bool back) {
    if (back == backwards) return;
    backwards = back;
    last.speed_mps = -last.speed_mps;
    for (auto& command : sent) command.second.speed_mps = -command.second.speed_mps;
  }

  [[nodiscard]] BaseState as_driven(BaseState state) const {
    if (!backwards) return state;
    state.yaw_rad += std::numbers::pi;
    state.twist.speed_mps = -state.twist.speed_mps;
    return state;
  }

  /// Where the base will be when a command given now reaches it.
  [[nodiscard]] BaseState predict(Time now, BaseState state) const {
    const Time until = now + from_seconds(params.delay_s);
    const double keep = params.lag_s > 0 ? std::exp(-kIntegrationStepS / params.lag_s) : 0.0;
    for (; state.stamp < until; state.stamp += from_seconds(kIntegrationStepS)) {
      const Twist2 command = command_in_force(state.stamp - from_seconds(params.delay_s));
      state.twist.speed_mps = command.speed_mps + keep * (state.twist.speed_mps - command.speed_mps);
      state.twist.turn_rate_radps =
          command.turn_rate_radps + keep * (state.twist.turn_rate_radps - command.turn_rate_radps);
      const double middle = state.yaw_rad + 0.5 * state.twist.turn_rate_radps * kIntegrationStepS;
      state.p_map_m += state.twist.speed_mps * kIntegrationStepS * Eigen::Vector2d(std::cos(middle), std::sin(middle));
      state.yaw_rad += state.twist.turn_rate_radps * kIntegrationStepS;
    }
    return state;
  }

  [[nodiscard]] Twist2 command_in_force(Time time) const {
    Twist2 command;
    for (const auto& [stamp, twist] : sent) {
      if (stamp > time) break;
      command = twist;
    }
    return command;
  }

  /// Time for which the limits let the command change.
  [[nodiscard]] double since_last_s(Time now) const {
    return sent.empty() ? params.period_s : std::clamp(to_seconds(now - sent.back().first), 0.0, params.period_s);
  }

  /// Less speed on the same arc: beside an obstacle, whoever planned the bend or ordered the stop has looked for room
  /// there and not straight on.
  [[nodiscard]] Twist2 slower(Time now) const {
    if (last.speed_mps <= 0) return {};
    const double less_mps = params.limits.max_acceleration_mps2 * since_last_s(now);
    const double keep = std::max(0.0, 1 - less_mps / last.speed_mps);
    return {keep * last.speed_mps, keep * last.turn_rate_radps};
  }

  TrackerOutput give(Time now, TrackerOutput output, const Twist2& wanted) {
    last = hold_to_limits(wanted, last, params.limits, since_last_s(now));
    sent.emplace_back(now, last);
    while (sent.size() > 2 && sent[1].first + from_seconds(params.delay_s + params.max_pose_age_s) < now) {
      sent.pop_front();
    }
    output.command = backwards ? Twist2{-last.speed_mps, last.turn_rate_radps} : last;
    output.mode = mode;
    return output;
  }

  TrackerOutput brake(Time now, TrackerOutput output, const std::string& reason) {
    TrackerOutput braking = give(now, std::move(output), slower(now));
    braking.mode = TrackerMode::kBrake;
    braking.reason = reason;
    plan.setZero();
    return braking;
  }

  /// Turn rate that ends at `error_rad` = 0 without passing it.
  [[nodiscard]] double turn_rate_to(double error_rad) const {
    const double stopping = std::sqrt(1.6 * params.limits.max_turn_acceleration_radps2 * std::abs(error_rad));
    return std::copysign(std::min({params.limits.max_turn_rate_radps, stopping, kTurnGainPerS * std::abs(error_rad)}),
                         error_rad);
  }

  TrackerOutput turn(Time now, TrackerOutput output, const BaseState& at, double heading_rad, double tolerance_rad,
                     TrackerMode next) {
    const double error = wrap_angle(heading_rad - at.yaw_rad);
    const bool standing = std::abs(at.twist.speed_mps) < kStandMps;
    if (std::abs(error) < tolerance_rad && std::abs(at.twist.turn_rate_radps) < kStandRadps && standing) mode = next;
    if (!standing) return give(now, std::move(output), slower(now));
    return give(now, std::move(output), {0, mode == next ? 0.0 : turn_rate_to(error)});
  }

  TrackerOutput track(Time now, TrackerOutput output, const BaseState& at, double across_m, double heading_error) {
    const Reference reference =
        make_reference(*path, s_m, std::max(at.twist.speed_mps, 0.0), params.limits.max_acceleration_mps2);
    Errors start;
    start << 0, across_m, heading_error, at.twist.speed_mps, at.twist.turn_rate_radps;
    const auto solution = solve(make_qp(reference, start, last, params), plan, kQpIterations);
    if (!solution.x.allFinite() || solution.violation > kMaxViolation) {
      // From a stand the path is turned to: the same problem would fail again.
      if (std::abs(last.speed_mps) <= kStandMps) mode = TrackerMode::kTurnToPath;
      return brake(now, std::move(output), "the solver did not converge");
    }
    plan = solution.x;
    return give(now, std::move(output), {std::max(plan(0), 0.0), plan(1)});  // within what the solver is off by
  }
};

PathTracker::PathTracker(const TrackerParams& params) : state_(std::make_unique<State>()) {
  config::check(params, "path tracker");
  state_->params = params;
}

PathTracker::~PathTracker() = default;
PathTracker::PathTracker(PathTracker&&) noexcept = default;
PathTracker& PathTracker::operator=(PathTracker&&) noexcept = default;

void PathTracker::follow(Path path, std::optional<double> goal_heading_rad, bool backwards) {
  state_->look(backwards);
  if (backwards && goal_heading_rad) *goal_heading_rad += std::numbers::pi;
  state_->path = std::move(path);
  state_->goal_heading_rad = goal_heading_rad;
  state_->mode = TrackerMode::kTurnToPath;
  state_->s_m = 0;
  state_->plan.setZero();
}

void PathTracker::stop() {
  state_->path.reset();
  state_->mode = TrackerMode::kIdle;
}

void PathTracker::halt() {
  state_->last = {};
  state_->sent.clear();
  state_->plan.setZero();
}

TrackerOutput PathTracker::brake(Time now, const std::string& reason) {
  return state_->brake(now, {}, reason);
}

TrackerOutput PathTracker::step(Time now, const BaseState& state) {
  State& s = *state_;
  TrackerOutput output;
  if (!s.path) return s.give(now, output, s.slower(now));
  if (!finite(state)) return s.brake(now, output, "the pose is not finite");
  const double age_s = to_seconds(now - state.stamp);
  if (age_s > s.params.max_pose_age_s || age_s < 0) return s.brake(now, output, "the pose is stale");

  const BaseState at = s.predict(now, s.as_driven(state));
  s.s_m = s.path->project(at.p_map_m, s.s_m - kSearchBackM, s.s_m + kSearchAheadM);
  const PathPoint nearest = s.path->at(s.s_m);
  const Eigen::Vector2d left(-std::sin(nearest.heading_rad), std::cos(nearest.heading_rad));
  output.cross_track_m = left.dot(at.p_map_m - nearest.p_m);
  output.remaining_m = s.path->length_m() - s.s_m;
  const double heading_error = wrap_angle(at.yaw_rad - nearest.heading_rad);
  if ((at.p_map_m - nearest.p_m).norm() > s.params.max_cross_track_m) {
    return s.brake(now, output, "too far from the path");
  }
  // A base that drives goes on to the new path without stopping, also out of a bend.
  const double turn_first = s.last.speed_mps > kStandMps ? kTurnFirstRad : kTurnFirstStandingRad;
  if (s.mode == TrackerMode::kTurnToPath && std::abs(heading_error) < turn_first &&
      (std::abs(s.last.turn_rate_radps) < kStandRadps || s.last.speed_mps > kStandMps)) {
    s.mode = TrackerMode::kTrack;
  }
  if (s.mode == TrackerMode::kTrack && output.remaining_m < kArrivedM) {
    s.mode = s.goal_heading_rad ? TrackerMode::kTurnToGoal : TrackerMode::kArrived;
  }
  switch (s.mode) {
    case TrackerMode::kTurnToPath:
      return s.turn(now, output, at, nearest.heading_rad, kTurnedRad, TrackerMode::kTrack);
    case TrackerMode::kTrack:
      return s.track(now, output, at, output.cross_track_m, heading_error);
    case TrackerMode::kTurnToGoal:
      return s.turn(now, output, at, *s.goal_heading_rad, kAtHeadingRad, TrackerMode::kArrived);
    default:
      return s.give(now, output, s.slower(now));
  }
}

}  // namespace arpent::control
