// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What viewpoints and tours ask about the ground: may the robot stand here, and how far is the drive. planning/local
// answers from the map.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "common/pose2.h"

namespace arpent::planning {

class FreeSpace {
 public:
  FreeSpace() = default;
  FreeSpace(const FreeSpace&) = delete;
  FreeSpace& operator=(const FreeSpace&) = delete;
  virtual ~FreeSpace() = default;

  /// Whether the footprint at this pose lies in known free space. Says nothing about how to get there.
  [[nodiscard]] virtual bool is_free(const Pose2& pose) const = 0;

  /// Length of the drive from one pose to each of the others [m], in their order; nullopt where there is no way, or it
  /// is longer than `max_m` (so that a search may end early).
  [[nodiscard]] virtual std::vector<std::optional<double>> distances_m(
      const Pose2& from, std::span<const Pose2> to, double max_m = std::numeric_limits<double>::infinity()) const = 0;

  [[nodiscard]] std::optional<double> distance_m(const Pose2& from, const Pose2& to) const {
    return distances_m(from, std::span(&to, 1)).front();
  }
};

}  // namespace arpent::planning
