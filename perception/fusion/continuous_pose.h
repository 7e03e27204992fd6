// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A pose without jumps for whoever steers by it: it moves as the best estimate says that the body moved, and closes the
// distance to the best estimate little by little.
#pragma once

#include "perception/fusion/pose_fusion.h"

namespace arpent::fusion {

struct BlendParams {
  double time_s = 0.1;
  double max_mps = 0.2;
  double max_radps = 0.3;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("time_s", self.time_s, "time constant: after three of it a correction is in",
                  config::between(0.001, 10.0));
    visitor.field("max_mps", self.max_mps, "corrections go no faster", config::greater_than(0.0));
    visitor.field("max_radps", self.max_radps, "the same for the rotation", config::greater_than(0.0));
  }
};

class ContinuousPose {
 public:
  explicit ContinuousPose(const BlendParams& params) : params_(params) {}

  /// The next pose. `best`: the estimate of now. `best_of_last`: what is now known of the moment of the last call;
  /// without it, in another frame, and while the one before was lost, the best is taken as it is. The covariance holds
  /// the distance that is left.
  [[nodiscard]] FusedPose next(const FusedPose& best, const std::optional<FusedPose>& best_of_last);
  /// Of the last pose, nullopt before the first.
  [[nodiscard]] std::optional<Time> last_stamp() const;

 private:
  BlendParams params_;
  std::optional<FusedPose> last_;
};

}  // namespace arpent::fusion
