// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A leg: the drive from one pose to the next, as motions, and what becomes of it on its way to the path tracker.
#pragma once

#include <optional>
#include <vector>

#include "planning/local/ground.h"
#include "planning/local/motion.h"

namespace arpent::planning {

/// Where and how a robot with slack at the start of a leg may move: within `along_m` of drive after the start the
/// footprint may reach `depth_m` into what is not free, because the start itself does.
struct StartSlack {
  double depth_m = 0;
  double along_m = 0.6;
};

struct Leg {
  Pose2 start;
  Pose2 goal;
  Motions motions;  ///< one begins where the one before ends; empty if start and goal are the same
  StartSlack slack;
};

/// A place on a leg: motion and share of it.
struct LegPlace {
  std::size_t motion = 0;
  double share = 0;
  double driven_m = 0;  ///< along the leg
};

/// Where the footprint first reaches into what is not free when it goes from `from` to the leg's end; nullopt if it
/// never does.
[[nodiscard]] std::optional<LegPlace> first_contact(const Ground& ground, const Motions& motions,
                                                    const StartSlack& slack = {}, const LegPlace& from = {});

/// Joins turns that follow each other and drives of equal curvature; leaves out what is nothing.
[[nodiscard]] Motions tidy(const Motions& motions);

/// How far along its leg a robot is; never goes back.
class LegProgress {
 public:
  explicit LegProgress(const Leg& leg);

  /// The place nearest to the pose among those up to a metre ahead (a metre counts as much as three radians).
  void advance(const Pose2& pose);
  [[nodiscard]] const LegPlace& place() const { return places_[at_].place; }
  /// Distance of the last pose from it.
  [[nodiscard]] double off_m() const { return off_m_; }

 private:
  struct Place {
    Pose2 pose;
    LegPlace place;
  };

  std::vector<Place> places_;
  std::size_t at_ = 0;
  double off_m_ = 0;
};

/// One piece is driven without a stop; at its end the robot turns on the spot to `end_heading_rad`. A tracker turns to
/// the first heading of a piece by itself.
struct DrivePiece {
  std::vector<Eigen::Vector2d> points_m;  ///< map frame, at least two, 5 cm apart: as control::Path takes them
  double end_heading_rad = 0;
  bool backwards = false;  ///< tail first: recoveries only
};

/// Splits a leg at its turns on the spot. Drives shorter than 3 cm are left out; a leg that only turns becomes one
/// piece of 3 cm forwards, for a path must have a length; a leg without motions becomes no piece.
[[nodiscard]] std::vector<DrivePiece> pieces_of(const Leg& leg);

/// The longest advance of a piece that only turns [m].
inline constexpr double kCreepM = 0.03;

}  // namespace arpent::planning
