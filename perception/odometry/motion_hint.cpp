// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/odometry/motion_hint.h"

#include <cmath>
#include <iterator>

namespace arpent::odometry {
namespace {

constexpr std::size_t kMost = 4096;
/// Readings of this long before a pair have come when the pair is looked at.
constexpr Duration kMargin = std::chrono::milliseconds(40);
constexpr Duration kSilent = std::chrono::milliseconds(120);

void add(std::map<Time, double>& readings, Time stamp, double value) {
  readings[stamp] = value;
  if (readings.size() > kMost) readings.erase(readings.begin());
}

/// The end of the readings that count for a pair; nullopt if there are none or they have fallen silent.
std::optional<std::map<Time, double>::const_iterator> usable_end(const std::map<Time, double>& readings, Time pair) {
  const auto end = readings.upper_bound(pair - kMargin);
  if (end == readings.begin() || pair - std::prev(end)->first > kSilent) return std::nullopt;
  return end;
}

/// Between the readings up to `last` as if they were joined by lines, beyond them as the two nearest go on; needs two.
double value_at(const std::map<Time, double>& readings, std::map<Time, double>::const_iterator last, Time at) {
  auto after = at > last->first ? last : readings.lower_bound(at);
  if (after == readings.begin()) ++after;
  const auto before = std::prev(after);
  const double share = to_seconds(at - before->first) / to_seconds(after->first - before->first);
  return before->second + share * (after->second - before->second);
}

}  // namespace

void MotionHint::add_turn_rate(Time stamp, double rate_radps) {
  add(rates_radps_, stamp, rate_radps);
}

void MotionHint::add_way(Time stamp, double way_m) {
  add(ways_m_, stamp, way_m);
}

std::optional<double> MotionHint::turn_rad(Time from, Time to) {
  const auto end = usable_end(rates_radps_, to);
  if (!end) return std::nullopt;
  double turn = 0;
  Time now = from;
  for (auto it = rates_radps_.cbegin(); it != *end; ++it) {
    if (it->first <= now) continue;
    turn += it->second * to_seconds(it->first - now);
    now = it->first;
  }
  turn += std::prev(*end)->second * to_seconds(to - now);
  rates_radps_.erase(rates_radps_.cbegin(), std::prev(*end));
  return turn;
}

std::optional<double> MotionHint::way_m(Time from, Time to) {
  const auto end = usable_end(ways_m_, to);
  if (!end || std::distance(ways_m_.cbegin(), *end) < 2 || from < ways_m_.begin()->first) return std::nullopt;
  const double way = value_at(ways_m_, std::prev(*end), to) - value_at(ways_m_, std::prev(*end), from);
  // The next step begins at `to`, before which two readings are wanted.
  ways_m_.erase(ways_m_.cbegin(), std::prev(*end, 2));
  return way;
}

std::optional<Pose> MotionHint::step(Time from, Time to, double speed_mps) {
  const auto turn = turn_rad(from, to);
  if (!turn) return std::nullopt;
  const double way = way_m(from, to).value_or(speed_mps * to_seconds(to - from));
  Pose T_from_to = Pose::Identity();
  T_from_to.linear() = so3_exp({0, 0, *turn});
  T_from_to.translation() = Eigen::Vector3d(way * std::cos(*turn / 2), way * std::sin(*turn / 2), 0);
  return T_from_to;
}

}  // namespace arpent::odometry
