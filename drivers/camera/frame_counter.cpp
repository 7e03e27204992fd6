// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/frame_counter.h"

namespace arpent::camera {
namespace {

/// A frame this far back is one that was overtaken; further back means that the device counts anew.
constexpr std::int64_t kMostOvertaken = 16;

}  // namespace

FrameCounter::Reading FrameCounter::read(std::int64_t id, std::int64_t period) {
  if (!last_id_) {
    last_id_ = id;
    return {Step::kForward, count_, 0};
  }
  std::int64_t step = id - *last_id_;
  const bool wraps = period > 0 && id <= period && *last_id_ <= period;
  if (wraps && step < -period / 2) step += period;
  if (wraps && step > period / 2) step -= period;
  if (step == 0) return {Step::kRepeated, count_, 0};
  if (step < 0 && step >= -kMostOvertaken) return {Step::kBackward, count_ + step, 0};
  last_id_ = id;
  if (step < 0) return {Step::kRestarted, ++count_, 0};
  count_ += step;
  return {Step::kForward, count_, step - 1};
}

}  // namespace arpent::camera
