// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The map's surface as triangles: marching cubes over every cell whose eight corners were seen. What is meshed does not
// depend on W_th, which is for planning. Meshes are kept per block, so that after one more depth image only what
// changed is meshed again.
#pragma once

#include <cstdint>
#include <memory>

#include "common/mesh.h"
#include "mapping/tsdf/tsdf_map.h"

namespace arpent::mapping {

class IncrementalMesher {
 public:
  IncrementalMesher();
  ~IncrementalMesher();
  IncrementalMesher(IncrementalMesher&&) noexcept;
  IncrementalMesher& operator=(IncrementalMesher&&) noexcept;

  /// Meshes again the blocks that changed since the last call (of the same map) and those that share cells with them.
  /// Returns how many.
  std::size_t update(const TsdfMap& map);

  /// The whole surface in the map frame: vertices shared between triangles (and blocks), normals pointing into empty
  /// space, triangles counter-clockwise seen from there. Equal to extract_mesh() of the same map.
  [[nodiscard]] TriangleMesh mesh() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

[[nodiscard]] TriangleMesh extract_mesh(const TsdfMap& map);

}  // namespace arpent::mapping
