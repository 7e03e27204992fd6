// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The light on every facet, computed once: lamps with shadows, ambient light that corners keep out, light thrown back
// by other surfaces, slow stains. Cameras look it up.
#pragma once

#include "sim/camera/tracer.h"

namespace arpent::sim {

/// A grid of irradiance over each facet's parallelogram.
class LightMap {
 public:
  struct Grid {
    int offset = 0;
    int nu = 2;
    int nv = 2;
  };

  [[nodiscard]] const Grid& grid(std::size_t facet) const { return grids_[facet]; }
  [[nodiscard]] const float* values() const { return values_.data(); }
  /// At (a, b) of the facet's parallelogram, linear between nodes.
  [[nodiscard]] float at(std::size_t facet, const Eigen::Vector2f& patch) const;

  std::vector<Grid> grids_;
  std::vector<float> values_;
};

/// Computes light from a world's lamps. Keeps references to its arguments.
class LightBaker {
 public:
  LightBaker(const World& world, const SurfaceMesh& mesh, const Tracer& tracer)
      : world_(world), mesh_(mesh), tracer_(tracer) {}

  /// The whole world, scaled to Lighting::mean; sets the scale that `bake_body` uses.
  [[nodiscard]] LightMap bake();

  /// What a moving body in this world receives: lamps with shadows of the world, and the world's mean of the rest. One
  /// value for each facet.
  [[nodiscard]] LightMap bake_body(const SurfaceMesh& body) const;

 private:
  [[nodiscard]] float direct(const Eigen::Vector3f& p, const Eigen::Vector3f& n, int samples) const;
  /// Light from other surfaces, and ambient light as far as it is not shut out.
  [[nodiscard]] float gather(const Eigen::Vector3f& p, const Eigen::Vector3f& n, const LightMap& light) const;
  [[nodiscard]] LightMap make_grids() const;
  /// Mean irradiance on what is in the region.
  [[nodiscard]] double mean_over_region(const LightMap& light) const;
  template <class Function>
  void for_each_node(LightMap& light, Function function) const;

  const World& world_;
  const SurfaceMesh& mesh_;
  const Tracer& tracer_;
  float scale_ = 1;
  float mean_indirect_ = 0;
};

}  // namespace arpent::sim
