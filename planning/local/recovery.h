// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a robot does that is boxed in, so that no leg starts where it stands: turn on the spot to where there is room,
// or back off along the way it came, which it has driven and so knows to be free. The one place where it drives
// backwards.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "planning/local/ground.h"
#include "planning/local/leg.h"

namespace arpent::planning {

struct RecoveryParams {
  double room_m = 0.02;
  double max_deeper_m = 0.01;
  double max_back_m = 1.5;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("room_m", self.room_m, "room about the footprint that ends a recovery", config::between(0.0, 0.5));
    visitor.field("max_deeper_m", self.max_deeper_m,
                  "on its way out the footprint may reach so much deeper into what blocks it than it does already",
                  config::between(0.0, 0.2));
    visitor.field("max_back_m", self.max_back_m, "longest way back", config::between(0.1, 10.0));
  }
};

/// The last metres driven, oldest first.
class Trail {
 public:
  explicit Trail(double length_m) : length_m_(length_m) {}
  /// Poses nearer than 3 cm and 0.1 rad to the last are left out.
  void add(const Pose2& pose);
  [[nodiscard]] const std::deque<Pose2>& poses() const { return poses_; }
  void clear() { poses_.clear(); }

 private:
  double length_m_;
  std::deque<Pose2> poses_;
};

/// What the tracker shall drive for it.
struct Recovery {
  std::optional<Motion> turn;    ///< on the spot; or else
  std::vector<Pose2> backwards;  ///< poses to be passed backwards, the nearest first
};

/// The smallest turn that gives room; or else the shortest way back to where the robot can turn, or if there is no such
/// place, as far back as it may. nullopt if neither gives room: the robot needs help, or a map that is right.
[[nodiscard]] std::optional<Recovery> plan_recovery(const Ground& ground, const Pose2& pose, const Trail& trail,
                                                    const RecoveryParams& params);

/// Straight backwards, or along the trail where that is not free: for a robot that touches what its map does not know.
/// Up to `length_m`, as far as it is free; nullopt if that is next to nothing.
[[nodiscard]] std::optional<Recovery> back_off(const Ground& ground, const Pose2& pose, const Trail& trail,
                                               double length_m, const RecoveryParams& params);

/// The piece that the path tracker drives.
[[nodiscard]] DrivePiece piece_of(const Recovery& recovery, const Pose2& pose);

/// Once about on the spot.
[[nodiscard]] std::vector<DrivePiece> turn_about(const Pose2& pose);

/// Where recoveries were tried: what did not help there is not tried for ever.
class TriedPoses {
 public:
  /// Notes a try at `pose`. False, and no note, if there were `most` about there before.
  bool try_at(const Pose2& pose, int most);

 private:
  std::vector<Pose2> poses_;
};

}  // namespace arpent::planning
