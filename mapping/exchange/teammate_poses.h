// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Where the teammates were when a depth image was taken, from the states that they send: for the mask.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/time.h"
#include "common/twist2.h"
#include "mapping/exchange/teammate_mask.h"

namespace arpent::mapping {

/// A teammate as it says itself.
struct TeammateState {
  std::string robot;
  Time stamp;
  Pose2 body;
  Twist2 twist;
};

class TeammatePoses {
 public:
  /// Older ones than the newest of the same robot are left out.
  void note(const TeammateState& state);
  /// All of them at `stamp`, moved on (or back) with their last twist. One that was silent for long has stood still
  /// since it braked.
  [[nodiscard]] std::vector<SeenTeammate> at(Time stamp) const;

 private:
  std::map<std::string, TeammateState> newest_;
};

}  // namespace arpent::mapping
