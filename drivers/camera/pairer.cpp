// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/pairer.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace arpent::camera {
namespace {

/// So many disagreements in a row mean that the counters or clocks are related otherwise than we believe.
constexpr int kMostDisagreements = 3;
/// Share of each new difference that the relation of the clocks follows. Two crystals drift apart by 0.1 ms in a second
/// at worst: at 5 Hz the relation lags 20 us / 0.2 behind, far within any tolerance.
constexpr double kFollow = 0.2;

/// A frame is in time within this part of half a period, the error at which the wrong frames would be taken for a pair.
constexpr int kPromptShare = 4;

Duration absolute(Duration d) {
  return d < Duration(0) ? -d : d;
}

}  // namespace

Time Pairer::host_time(const Stream& stream, Time device) const {
  return params_.clocks == "bus" ? device : stream.clock.to_host(device);
}

void Pairer::start_session(Stream& stream, const Frame& frame) {
  stream.counter = {};
  stream.clock.clear();
  stream.waiting.clear();
  stream.last.reset();
  stream.session = frame.session;
  lock_.reset();
}

bool Pairer::admit(Side side, const Frame& frame) {
  Stream& s = stream(side);
  const auto index = static_cast<std::size_t>(side);
  const FrameCounter::Reading reading = s.counter.read(frame.frame_id, frame.id_period);
  if (reading.step == FrameCounter::Step::kRepeated) ++counts_.repeated[index];
  if (reading.step == FrameCounter::Step::kBackward) ++counts_.overtaken[index];
  if (reading.step == FrameCounter::Step::kRepeated || reading.step == FrameCounter::Step::kBackward) return false;
  if (reading.step == FrameCounter::Step::kRestarted) {
    start_session(s, frame);
    return admit(side, frame);
  }
  counts_.missed[index] += reading.missed;
  if (s.last) s.period = (frame.device_time - s.last->frame.device_time) / (reading.count - s.last->count);
  s.last = Waiting{{}, reading.count};
  s.last->frame.device_time = frame.device_time;
  s.clock.add(frame.device_time, frame.arrival - Duration(frame.exposure_us) - from_seconds(params_.transfer_s));
  return true;
}

void Pairer::add(Side side, Frame frame) {
  Stream& s = stream(side);
  if (s.last && frame.session != s.session) start_session(s, frame);
  s.session = frame.session;
  if (!admit(side, frame)) return;
  s.waiting.push_back({std::move(frame), s.last->count});
  if (!lock_) lock();
  if (lock_) match();
  while (s.waiting.size() > static_cast<std::size_t>(params_.queue)) drop_front(side);
}

void Pairer::drop_front(Side side) {
  ++counts_.unpaired[static_cast<std::size_t>(side)];
  stream(side).waiting.pop_front();
}

Duration Pairer::half_period() const {
  const auto& left = streams_[0].period;
  const auto& right = streams_[1].period;
  if (!left && !right) return from_seconds(params_.tolerance_s);
  return std::max(from_seconds(params_.tolerance_s), std::min(left.value_or(*right), right.value_or(*left)) / 2);
}

/// A computer that is busy at the start gets the first frames late, and often all of one camera: clocks related by
/// these would lie a period apart. Late frames lie scattered, those in time do not.
bool Pairer::settled(const Stream& stream) const {
  return stream.clock.prompt(half_period() / kPromptShare) >= static_cast<std::size_t>(params_.warm_up_frames);
}

void Pairer::lock() {
  Stream& left = streams_[0];
  Stream& right = streams_[1];
  if (left.waiting.empty() || right.waiting.empty()) return;
  const bool separate = params_.clocks == "separate";
  if (separate && !(settled(left) && settled(right))) return;
  const Waiting& newest = left.waiting.back();
  const auto apart = [&](const Waiting& w) {
    const Duration device = w.frame.device_time - newest.frame.device_time;
    return absolute(separate ? host_time(right, w.frame.device_time) - host_time(left, newest.frame.device_time)
                             : device);
  };
  const auto nearest = std::min_element(right.waiting.begin(), right.waiting.end(),
                                        [&](const Waiting& a, const Waiting& b) { return apart(a) < apart(b); });
  if (apart(*nearest) > (separate ? half_period() : from_seconds(params_.tolerance_s))) return;
  lock_ = Lock{nearest->count - newest.count,
               separate ? nearest->frame.device_time - newest.frame.device_time : Duration(0)};
  disagreements_ = 0;
  ++counts_.locks;
  counts_.warm_up += static_cast<std::int64_t>(left.waiting.size() - 1) + (nearest - right.waiting.begin());
  right.waiting.erase(right.waiting.begin(), nearest);
  left.waiting.erase(left.waiting.begin(), left.waiting.end() - 1);
}

int Pairer::compare(const Waiting& left, const Waiting& right) const {
  if (params_.by == "frame_id") {
    const std::int64_t ahead = right.count - left.count - lock_->right_minus_left_count;
    return ahead > 0 ? -1 : ahead < 0 ? 1 : 0;
  }
  const Duration ahead = right.frame.device_time - left.frame.device_time - lock_->right_minus_left_clock;
  return ahead > half_period() ? -1 : ahead < -half_period() ? 1 : 0;
}

void Pairer::match() {
  auto& left = streams_[0].waiting;
  auto& right = streams_[1].waiting;
  while (lock_ && !left.empty() && !right.empty()) {
    const int order = compare(left.front(), right.front());
    if (order < 0) drop_front(Side::kLeft);
    if (order > 0) drop_front(Side::kRight);
    if (order != 0) continue;
    join(left.front(), right.front());
    left.pop_front();
    right.pop_front();
  }
}

std::int64_t Pairer::next_sequence(const Waiting& left) {
  const bool same_session = last_sequence_ && left.frame.session == last_left_session_;
  const std::int64_t step = same_session ? std::max<std::int64_t>(1, left.count - last_left_count_) : 1;
  last_sequence_ = last_sequence_ ? *last_sequence_ + step : 0;
  last_left_count_ = left.count;
  last_left_session_ = left.frame.session;
  return *last_sequence_;
}

void Pairer::join(const Waiting& left, const Waiting& right) {
  const Duration between = right.frame.device_time - left.frame.device_time;
  const Duration skew = between - lock_->right_minus_left_clock;
  const Duration apart_by_arrival =
      absolute(host_time(streams_[1], right.frame.device_time) - host_time(streams_[0], left.frame.device_time));
  const bool separate = params_.clocks == "separate";
  const bool one_period_off = separate && apart_by_arrival > half_period();
  if (absolute(skew) > from_seconds(params_.tolerance_s) || one_period_off) {
    ++counts_.out_of_tolerance;
    if (++disagreements_ >= kMostDisagreements) lock_.reset();
    return;
  }
  disagreements_ = 0;
  if (separate) lock_->right_minus_left_clock += from_seconds(kFollow * to_seconds(skew));
  ++counts_.pairs;
  FramePair pair{left.frame, right.frame, next_sequence(left), {}, skew};
  pair.stamp = host_time(streams_[0], left.frame.device_time) + Duration(left.frame.exposure_us / 2);
  ready_.push_back(std::move(pair));
}

std::vector<FramePair> Pairer::take() {
  return std::exchange(ready_, {});
}

}  // namespace arpent::camera
