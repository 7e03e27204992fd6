// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Joins two streams by their measurement time, so that what a process does with both does not depend on which message
// came first. Each item of the left stream is paired with the right item of the same stamp, in stamp order. A left item
// waits until the right stream has reached its stamp; if that stream passes it without an equal stamp, or it falls
// `horizon` behind its own stream, it is given out unpaired.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "common/time.h"

namespace arpent {

template <class Left, class Right>
class TimeJoin {
 public:
  struct Joined {
    Time stamp;
    Left left;
    std::optional<Right> right;  ///< absent if the right stream has nothing of this stamp
  };

  explicit TimeJoin(Duration horizon) : horizon_(horizon) {}

  /// False (and nothing is kept) if the stream goes back in time.
  [[nodiscard]] bool push_left(Time stamp, Left item) {
    if (newest_left_ && stamp <= *newest_left_) return false;
    newest_left_ = stamp;
    waiting_.emplace_back(stamp, std::move(item));
    return true;
  }

  [[nodiscard]] bool push_right(Time stamp, Right item) {
    if (newest_right_ && stamp <= *newest_right_) return false;
    newest_right_ = stamp;
    rights_.emplace(stamp, std::move(item));
    rights_.erase(rights_.begin(), rights_.lower_bound(stamp - horizon_));
    return true;
  }

  /// The left items whose fate is decided, in stamp order.
  [[nodiscard]] std::vector<Joined> take() {
    std::vector<Joined> joined;
    while (!waiting_.empty() && decided(waiting_.front().first)) {
      auto& [stamp, item] = waiting_.front();
      const auto right = rights_.find(stamp);
      joined.push_back({stamp, std::move(item), right == rights_.end() ? std::nullopt : std::optional(right->second)});
      rights_.erase(rights_.begin(), rights_.upper_bound(stamp));
      waiting_.pop_front();
    }
    return joined;
  }

  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }

 private:
  [[nodiscard]] bool decided(Time stamp) const {
    return (newest_right_ && *newest_right_ >= stamp) || *newest_left_ - stamp > horizon_;
  }

  Duration horizon_;
  std::deque<std::pair<Time, Left>> waiting_;
  std::map<Time, Right> rights_;
  std::optional<Time> newest_left_;
  std::optional<Time> newest_right_;
};

}  // namespace arpent
