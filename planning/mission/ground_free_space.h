// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What the viewpoints ask about the ground, answered from the newest map. Places to which no leg was found are not
// free, as long as nothing changed there.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "planning/local/sweep.h"
#include "planning/local/unreachable.h"
#include "planning/viewpoints/free_space.h"

namespace arpent::planning {

class GroundFreeSpace : public FreeSpace {
 public:
  /// `turnable`: only places count where the robot can turn on the spot, so that it gets away again: the camera does
  /// not see beside it, and a robot that drives forwards only gets stuck in a slot of known ground.
  GroundFreeSpace(const Ground& ground, const GroundGrid& grid, const UnreachableGoals& unreachable, const Pose2& robot,
                  bool turnable)
      : ground_(ground), grid_(grid), unreachable_(unreachable), robot_(robot), turnable_(turnable) {}

  [[nodiscard]] bool is_free(const Pose2& pose) const override {
    const bool room = !turnable_ || ground_.clearance_m(pose.position_m()) >= ground_.footprint().long_m();
    return room && ground_.is_free(pose) && !unreachable_.find(pose, robot_, grid_);
  }
  [[nodiscard]] std::vector<std::optional<double>> distances_m(const Pose2& from, std::span<const Pose2> to,
                                                               double max_m) const override {
    return drive_lengths_m(ground_, from, to, max_m);
  }

 private:
  const Ground& ground_;
  const GroundGrid& grid_;
  const UnreachableGoals& unreachable_;
  Pose2 robot_;
  bool turnable_;
};

}  // namespace arpent::planning
