// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Rays against triangles, eight at a time, with Embree. Pinned to AVX2 and one thread: every machine of this class
// finds the same hits to the last bit.
#pragma once

#include <memory>

#include "sim/world/surface_mesh.h"

namespace arpent::sim {

inline constexpr int kLanes = 8;

/// Eight rays origin + t direction. `t`: before, how far to look; after, where the nearest hit is. `facet`: -1 where
/// nothing is hit. A lane with t < 0 is left out.
struct alignas(32) RayPacket {
  std::array<std::array<float, kLanes>, 3> origin;
  std::array<std::array<float, kLanes>, 3> direction;
  std::array<float, kLanes> t;
  std::array<int, kLanes> facet;
};

class Tracer {
 public:
  /// `first_facet` is added to the mesh's facet numbers, for a second mesh beside the world's.
  explicit Tracer(const SurfaceMesh& mesh, int first_facet = 0);
  ~Tracer();
  Tracer(Tracer&&) noexcept;
  Tracer& operator=(Tracer&&) noexcept;

  /// Updates the lanes in which this mesh is hit before `t`; others keep what they have. May be called by several
  /// threads.
  void intersect(RayPacket& packet) const { intersect(packet, true); }
  /// The same for rays to all sides.
  void intersect_scattered(RayPacket& packet) const { intersect(packet, false); }
  /// Sets `facet` to 0 where anything lies before `t`, else to -1.
  void find_occluded(RayPacket& packet) const;

 private:
  void intersect(RayPacket& packet, bool coherent) const;

  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace arpent::sim
