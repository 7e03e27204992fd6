// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/fusion/pose_fusion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "common/config/config.h"

namespace arpent::fusion {
namespace {

constexpr Duration kHorizon = std::chrono::seconds(2);
/// Wheels and gyro are taken to go on like this for so long.
constexpr Duration kHold = std::chrono::milliseconds(100);
/// The way between odometer readings this far apart is taken to have been even.
constexpr Duration kMaxWheelGap = std::chrono::seconds(1);
/// Odometers that have not moved by more than this for so long stand.
constexpr Duration kStillFor = std::chrono::milliseconds(200);
constexpr double kStillM = 5e-4;

double share(Duration part, Duration whole) {
  return static_cast<double>(part.count()) / static_cast<double>(whole.count());
}

}  // namespace

PoseFusion::PoseFusion(const FusionParams& params) : params_(params), filter_(params) {
  config::check(params, "fused pose");
}

std::string PoseFusion::admit(Stream& stream, Time stamp, bool leads) {
  const bool ordered = !stream.last || stamp > *stream.last;
  const bool ahead = newest_ && stamp > *newest_ + kHorizon;
  const bool behind = newest_ && stamp < *newest_ - kHorizon;
  if (ordered && behind) return "older than what is kept";
  if (!ordered && !behind) return "its time is not after the last one's";
  if (ahead || behind) {
    const bool follows = stream.suspect && stamp > *stream.suspect && stamp <= *stream.suspect + kHorizon;
    stream.suspect = stamp;
    if (!leads || !follows) return "its time leaps";
    restart(stamp);
  }
  if (!base_) begin(stamp);
  stream.suspect.reset();
  stream.last = stamp;
  newest_ = newest_ ? std::max(*newest_, stamp) : stamp;
  return "";
}

void PoseFusion::begin(Time stamp) {
  base_ = filter_.initial(stamp - kHorizon);
}

void PoseFusion::restart(Time stamp) {
  FilterState state = state_at(*newest_);
  filter_.leap(state, stamp - kHold);
  base_ = std::move(state);
  nodes_.clear();
  wheels_.clear();
  gyro_.clear();
  newest_.reset();
  wheel_stream_ = gyro_stream_ = odometry_stream_ = tag_stream_ = {};
}

void PoseFusion::forget_states(Time from) {
  for (auto it = nodes_.rbegin(); it != nodes_.rend() && it->first >= from; ++it) it->second.after.reset();
}

/// Moves the base to the newest state that is older than the horizon.
void PoseFusion::forget_old() {
  const Time oldest = *newest_ - kHorizon;
  if (nodes_.empty() || nodes_.begin()->first >= oldest) return;
  const auto kept = nodes_.lower_bound(oldest);
  base_ = state_at(std::prev(kept)->first);
  nodes_.erase(nodes_.begin(), kept);
  const auto cut = [&](auto& readings) {
    auto first = readings.upper_bound(base_->stamp);
    if (first != readings.begin()) --first;
    readings.erase(readings.begin(), first);
  };
  cut(wheels_);
  cut(gyro_);
}

bool PoseFusion::is_still(const WheelReading& reading) const {
  if (reading.commanded.speed_mps != 0 || reading.commanded.turn_rate_radps != 0) return false;
  for (auto it = wheels_.rbegin(); it != wheels_.rend(); ++it) {
    const WheelReading& before = it->second.reading;
    if (std::abs(before.left_m - reading.left_m) > kStillM || std::abs(before.right_m - reading.right_m) > kStillM) {
      return false;
    }
    if (reading.stamp - before.stamp >= kStillFor) return true;
  }
  return false;
}

std::string PoseFusion::add(const WheelReading& reading) {
  std::string fault = admit(wheel_stream_, reading.stamp, true);
  if (!fault.empty()) return fault;
  const bool still = is_still(reading);
  forget_states(wheels_.empty() ? reading.stamp - kHold : wheels_.rbegin()->first + Duration(1));
  wheels_.emplace(reading.stamp, WheelSample{reading, still});
  nodes_[reading.stamp];
  forget_old();
  return "";
}

std::string PoseFusion::add(const GyroReading& reading) {
  std::string fault = admit(gyro_stream_, reading.stamp, false);
  if (!fault.empty() || !params_.gyro.used) return fault;
  forget_states(gyro_.empty() ? reading.stamp - kHold : gyro_.rbegin()->first + Duration(1));
  gyro_.emplace(reading.stamp, reading.yaw_rate_radps);
  forget_old();
  return "";
}

std::string PoseFusion::add(const OdometryReading& reading) {
  std::string fault = admit(odometry_stream_, reading.stamp, true);
  if (!fault.empty()) return fault;
  forget_states(reading.stamp);
  nodes_[reading.stamp].odometry = reading;
  forget_old();
  return "";
}

std::string PoseFusion::add(const WorldReading& tag) {
  std::string fault = admit(tag_stream_, tag.stamp, false);
  if (!fault.empty()) return fault;
  forget_states(tag.stamp);
  nodes_[tag.stamp].tag = tag;
  forget_old();
  return "";
}

std::string PoseFusion::add(const AlignmentReading& reading) {
  if (!base_) return "nothing to align yet";
  if (reading.stamp > *newest_ + kHorizon) return "its time leaps";
  // Where a frame lies does not age: an older alignment counts from the oldest moment that is kept.
  const Time stamp = std::max(reading.stamp, base_->stamp + Duration(1));
  newest_ = std::max(*newest_, stamp);
  forget_states(stamp);
  nodes_[stamp].alignment = reading;
  forget_old();
  return "";
}

std::optional<Interval::Wheels> PoseFusion::wheels_between(Time from, Time to) const {
  auto end = wheels_.lower_bound(to);
  const bool extrapolated = end == wheels_.end();
  if (extrapolated && end != wheels_.begin()) --end;
  if (end == wheels_.begin() || end == wheels_.end()) return std::nullopt;
  const WheelReading& a = std::prev(end)->second.reading;
  const WheelReading& b = end->second.reading;
  const Duration gap = b.stamp - a.stamp;
  if (!b.usable || gap > kMaxWheelGap || (extrapolated ? to - b.stamp > kHold : from < a.stamp)) return std::nullopt;
  const double s = share(to - from, gap);
  const double left_m = s * (b.left_m - a.left_m), right_m = s * (b.right_m - a.right_m);
  const double way_m = std::max(std::abs(left_m), std::abs(right_m));
  // Faster than any robot of ours by far: a count that jumped.
  if (way_m > 2 * params_.odometry.max_speed_mps * to_seconds(to - from)) return std::nullopt;
  return Interval::Wheels{0.5 * (left_m + right_m), (right_m - left_m) / params_.wheels.track_m, end->second.still};
}

std::optional<double> PoseFusion::gyro_rate_at(Time stamp) const {
  const auto after = gyro_.lower_bound(stamp);
  if (after == gyro_.end()) {
    if (gyro_.empty() || stamp - gyro_.rbegin()->first > kHold) return std::nullopt;
    return gyro_.rbegin()->second;
  }
  if (after == gyro_.begin()) {
    if (after->first - stamp > kHold) return std::nullopt;
    return after->second;
  }
  const auto before = std::prev(after);
  if (after->first - before->first > kHold) return std::nullopt;
  const double s = share(stamp - before->first, after->first - before->first);
  return before->second + s * (after->second - before->second);
}

/// The integral of the readings, joined by straight lines.
std::optional<double> PoseFusion::gyro_between(Time from, Time to) const {
  std::optional<double> rate = gyro_rate_at(from);
  if (!rate) return std::nullopt;
  double turn_rad = 0;
  Time at = from;
  for (auto it = gyro_.upper_bound(from); at < to; ++it) {
    const Time next = it == gyro_.end() ? to : std::min(it->first, to);
    const std::optional<double> next_rate = gyro_rate_at(next);
    if (!next_rate) return std::nullopt;
    turn_rad += 0.5 * (*rate + *next_rate) * to_seconds(next - at);
    rate = next_rate;
    at = next;
    if (it == gyro_.end()) break;
  }
  return turn_rad;
}

void PoseFusion::advance(FilterState& state, Time to) const {
  if (to <= state.stamp) return;
  filter_.predict(state,
                  {to_seconds(to - state.stamp), wheels_between(state.stamp, to), gyro_between(state.stamp, to)});
  state.stamp = to;
}

/// Computes what is missing up to `stamp`, and keeps it.
FilterState PoseFusion::state_at(Time stamp) {
  const auto end = nodes_.upper_bound(stamp);
  auto it = end;
  while (it != nodes_.begin() && !std::prev(it)->second.after) --it;
  FilterState state = it == nodes_.begin() ? *base_ : *std::prev(it)->second.after;
  for (; it != end; ++it) {
    Node& node = it->second;
    advance(state, it->first);
    if (node.odometry) filter_.correct(state, *node.odometry);
    if (node.alignment) filter_.correct(state, *node.alignment);
    if (node.tag) filter_.correct(state, *node.tag);
    node.after = state;
  }
  advance(state, stamp);
  return state;
}

std::optional<FusedPose> PoseFusion::at(Time stamp) {
  if (!base_ || !newest_ || stamp < base_->stamp || stamp > *newest_ + kHorizon) return std::nullopt;
  return to_pose(state_at(stamp));
}

std::optional<FilterState> PoseFusion::newest_state() {
  if (!base_ || !newest_) return std::nullopt;
  return state_at(*newest_);
}

FusedPose PoseFusion::to_pose(const FilterState& state) const {
  FusedPose pose;
  pose.stamp = state.stamp;
  pose.frame = state.frame;
  pose.T_frame_body = state.T_frame_body;
  pose.twist = state.twist;
  pose.covariance = state.P.topLeftCorner<6, 6>();
  pose.odometry_stamp = state.odometry_stamp;
  const auto drift = state.since_odometry.covariance.diagonal();
  const double drift_m = std::sqrt(std::max({drift(0), drift(1), 0.0}));
  const double drift_rad = std::sqrt(std::max(drift(5), 0.0));
  if (!state.started) {
    pose.reason = state.odometry_fault.empty() ? "no visual odometry yet" : state.odometry_fault;
  } else if (drift_m > params_.max_dead_reckoning_m || drift_rad > params_.max_dead_reckoning_rad) {
    pose.reason = fmt::format("dead reckoning is uncertain by {:.2f} m and {:.2f} rad", drift_m, drift_rad);
    if (!state.odometry_fault.empty()) pose.reason += "; " + state.odometry_fault;
  } else if (!state.odometry_fault.empty()) {
    pose.status = Status::kDeadReckoning;
    pose.reason = state.odometry_fault;
  } else if (to_seconds(state.stamp - *state.odometry_stamp) > params_.odometry.timeout_s) {
    pose.status = Status::kDeadReckoning;
    pose.reason = "visual odometry is silent";
  } else {
    pose.status = Status::kOk;
  }
  return pose;
}

}  // namespace arpent::fusion
