// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a station has sent, for when its transport is connected anew: the transport's own history ends with it. All of
// it is sent again then; receivers drop what they have.
#pragma once

#include <deque>
#include <utility>
#include <vector>

#include "link/types.h"

namespace arpent::link {

class SentHistory {
 public:
  explicit SentHistory(int max_parts) : max_parts_(static_cast<std::size_t>(max_parts)) {}

  void add(const Command& command) {
    commands_.push_back(command);
    if (commands_.size() > kMaxCommands) commands_.pop_front();
  }
  void add(const std::vector<Part>& parts) {
    for (const Part& part : parts) {
      parts_.push_back(part);
      bytes_ += part.data.size();
    }
    while (parts_.size() > max_parts_ || bytes_ > kMaxBytes) {
      bytes_ -= parts_.front().data.size();
      parts_.pop_front();
    }
  }

  /// Those added since the last call.
  [[nodiscard]] std::deque<Command> take_commands() { return std::exchange(commands_, {}); }
  [[nodiscard]] std::vector<Part> parts() const { return {parts_.begin(), parts_.end()}; }

 private:
  static constexpr std::size_t kMaxCommands = 256;
  static constexpr std::size_t kMaxBytes = std::size_t{30} << 20;

  std::size_t max_parts_;
  std::size_t bytes_ = 0;
  std::deque<Command> commands_;
  std::deque<Part> parts_;
};

}  // namespace arpent::link
