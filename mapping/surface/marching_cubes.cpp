// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/surface/marching_cubes.h"

namespace arpent::mapping {
namespace {

/// The corners of each face, counter-clockwise seen from outside the cell.
constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

int edge_between(int a, int b) {
  for (int e = 0; e < 12; ++e) {
    const auto& [low, high] = kEdgeCorners[static_cast<std::size_t>(e)];
    if ((low == a && high == b) || (low == b && high == a)) return e;
  }
  return -1;
}

/// For each crossed edge the next one around the cell. On a face, each run of inside corners is cut off by a line from
/// the edge where the run ends to the edge where it began. Every crossed edge leaves the inside on one of its two faces
/// and enters it on the other, so this is a permutation.
std::array<int, 12> link_edges(std::uint8_t inside) {
  std::array<int, 12> next{};
  next.fill(-1);
  const auto is_inside = [&](int corner) { return (inside >> corner & 1) != 0; };
  for (const auto& face : kFaces) {
    for (int end = 0; end < 4; ++end) {
      if (!is_inside(face[end]) || is_inside(face[(end + 1) % 4])) continue;
      int start = end;
      while (is_inside(face[(start + 3) % 4])) start = (start + 3) % 4;
      const int leaving = edge_between(face[end], face[(end + 1) % 4]);
      const int entering = edge_between(face[(start + 3) % 4], face[start]);
      next[static_cast<std::size_t>(leaving)] = entering;
    }
  }
  return next;
}

CellTriangles make_case(std::uint8_t inside) {
  CellTriangles triangles;
  std::array<int, 12> next = link_edges(inside);
  for (int first = 0; first < 12; ++first) {
    std::vector<std::uint8_t> loop;
    for (int edge = first; next[static_cast<std::size_t>(edge)] >= 0;) {
      loop.push_back(static_cast<std::uint8_t>(edge));
      const int following = next[static_cast<std::size_t>(edge)];
      next[static_cast<std::size_t>(edge)] = -1;
      edge = following;
    }
    for (std::size_t i = 2; i < loop.size(); ++i) triangles.push_back({loop[0], loop[i], loop[i - 1]});
  }
  return triangles;
}

std::array<CellTriangles, 256> make_table() {
  std::array<CellTriangles, 256> table;
  for (int inside = 0; inside < 256; ++inside) {
    table[static_cast<std::size_t>(inside)] = make_case(static_cast<std::uint8_t>(inside));
  }
  return table;
}

}  // namespace

const CellTriangles& marching_cubes_case(std::uint8_t inside) {
  static const auto table = make_table();
  return table[inside];
}

}  // namespace arpent::mapping
