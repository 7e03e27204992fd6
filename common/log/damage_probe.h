// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How much of a log survives damage: used by the test and by bench `wire`.
#pragma once

#include <cstdint>
#include <filesystem>

namespace arpent {

struct DamageProbe {
  std::int64_t cases = 0;
  std::int64_t most_lost =
      0;  ///< events of the whole log that a damaged copy no longer gives back unchanged, the worst case
};

/// Reads copies of the log cut at every length, and with every byte flipped (all bits, and one bit). An event that the
/// cut itself removes does not count as lost, but the one it goes through does.
[[nodiscard]] DamageProbe probe_damage(const std::filesystem::path& log, const std::filesystem::path& scratch_file);

}  // namespace arpent
