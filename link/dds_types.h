// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Envelopes <-> the C structs that idlc makes of link_messages.idl.
#pragma once

#include <array>

#include "link/types.h"
#include "link_messages.h"

namespace arpent::link {

/// The sample borrows from `message`, which must outlive it.
struct BorrowedBeat {
  explicit BorrowedBeat(const Beat& message);
  arpent_link_BeatSample sample{};

 private:
  std::vector<std::array<char, kMaxStationName + 1>> hears_;
};
struct BorrowedPart {
  explicit BorrowedPart(const Part& message);
  arpent_link_PartSample sample{};
};
struct BorrowedCommand {
  explicit BorrowedCommand(const Command& message);
  arpent_link_CommandSample sample{};

 private:
  std::vector<arpent_link_EchoSample> heard_;
};

[[nodiscard]] Beat to_beat(const arpent_link_BeatSample& sample);
[[nodiscard]] Command to_command(const arpent_link_CommandSample& sample);
[[nodiscard]] Part to_part(const arpent_link_PartSample& sample);

}  // namespace arpent::link
