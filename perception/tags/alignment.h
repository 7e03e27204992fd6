// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Where the odometry frame lies in the world (thesis Sect. 5.2.2), from several pairs that agree: each gives
// T_world_body by the tags and T_odom_body by the odometry. They are averaged by their covariances, and the ground is
// applied once to the average, not once per view.
//
// What averaging is worth: the noise of the pixels differs from pair to pair, but how an edge falls on the pixels, the
// cube's own errors and the calibration are the same for a robot at rest. The average of n views is therefore given
// the covariance of one, times (shared + (1 - shared) / n) (bench `tags` measures 0.4 on pictures without such errors
// of cube and calibration); a robot that moves between the views does better than that.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "common/config/fields.h"
#include "common/geometry.h"
#include "common/time.h"
#include "perception/tags/cube_pose.h"

namespace arpent::tags {

struct AlignmentParams {
  int views = 5;
  int max_views = 20;
  double shared = 0.5;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("views", self.views, "agreeing pairs from which the alignment is first made",
                  config::between(2, 100));
    visitor.field("max_views", self.max_views,
                  "agreeing pairs at which it is final; it is made anew whenever their number has doubled",
                  config::between(2, 400));
    visitor.field("shared", self.shared, "share of a view's variance that all views of a robot at rest have in common",
                  config::between(0.0, 1.0));
  }
};

/// T_world_odom as one pair gives it. Covariance: tangent of retract() at it, translation [m] and rotation [rad] in the
/// axes of odom.
struct AlignmentView {
  Time stamp;
  Pose T_world_odom = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();
};

/// Joins the two poses of one pair. `covariance_body`: of T_world_body; `covariance_odom_body`: of T_odom_body,
/// accumulated since odom's origin; both in body axes.
[[nodiscard]] AlignmentView make_view(Time stamp, const Pose& T_world_body, const Matrix6d& covariance_body,
                                      const Pose& T_odom_body, const Matrix6d& covariance_odom_body);

struct Alignment {
  Time stamp;  ///< of the newest view in it
  Pose T_world_odom = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< as of a view
  int views = 0;
  /// Squared distance of the average from an odom that stands on the ground: beyond kGroundGate the tags contradict it.
  double ground_chi2 = 0;
};

class FrameAligner {
 public:
  /// Throws InputError for parameters that cannot be used.
  FrameAligner(const AlignmentParams& params, const GroundParams& ground);

  /// Takes a view, newer than the last one. Returns the alignment when it is first known and when it is made anew.
  [[nodiscard]] std::optional<Alignment> add(const AlignmentView& view);
  /// The odometry lost its way at `stamp`: what it says later is in another frame than before. All is forgotten, and
  /// views up to then are refused.
  void forget(Time stamp);

  [[nodiscard]] bool is_aligned() const { return alignment_.has_value(); }
  /// True once max_views agree.
  [[nodiscard]] bool is_final() const { return alignment_ && alignment_->views >= params_.max_views; }
  /// Views that did not agree with the others.
  [[nodiscard]] std::int64_t disagreeing() const { return disagreeing_; }

 private:
  [[nodiscard]] std::deque<AlignmentView> largest_agreement() const;
  [[nodiscard]] Alignment average(const std::deque<AlignmentView>& views) const;

  AlignmentParams params_;
  GroundParams ground_;
  std::deque<AlignmentView> views_;
  std::optional<Alignment> alignment_;
  std::optional<Time> forgotten_;
  std::int64_t disagreeing_ = 0;
};

}  // namespace arpent::tags
