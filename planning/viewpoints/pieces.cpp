// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/pieces.h"

#include <unordered_map>

#include "mapping/tsdf/storage.h"

namespace arpent::planning {

using mapping::VoxelIndex;

std::vector<std::size_t> piece_sizes(std::span<const VoxelIndex> elements, std::span<const std::uint8_t> counted) {
  std::unordered_map<VoxelIndex, std::size_t, mapping::BlockHash> unvisited;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (counted.empty() || counted[i] != 0) unvisited.emplace(elements[i], i);
  }
  std::vector<std::size_t> sizes(elements.size());
  std::vector<std::size_t> piece;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (unvisited.erase(elements[i]) == 0) continue;
    piece.assign(1, i);
    for (std::size_t next = 0; next < piece.size(); ++next) {
      for (int n = 0; n < 27; ++n) {
        const VoxelIndex offset(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
        const auto found = unvisited.find(elements[piece[next]] + offset);
        if (found == unvisited.end()) continue;
        piece.push_back(found->second);
        unvisited.erase(found);
      }
    }
    for (const std::size_t member : piece) sizes[member] = piece.size();
  }
  return sizes;
}

}  // namespace arpent::planning
