// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What surfaces look like from a distance: the reflectance of facets at eight points at once, filtered to the pixels'
// footprint.
#pragma once

#include <vector>

#include "sim/camera/mip_map.h"
#include "sim/world/surface_mesh.h"

namespace arpent::sim {

using Lanes = std::array<float, 8>;
using LanePoints = std::array<Lanes, 3>;

/// The area that a pixel sees on a surface: `minor_m` across, `major_m` along the unit vector `along`.
struct PixelFootprint {
  float minor_m = 0;
  float major_m = 0;
  Eigen::Vector3f along = Eigen::Vector3f::UnitX();
};

class Materials {
 public:
  Materials(const World& world, const SurfaceMesh& mesh);

  /// Reflectance of `facet` at eight points in world coordinates.
  void reflectance(const Facet& facet, const LanePoints& p_world_m, const PixelFootprint& footprint,
                   Lanes& values) const;

 private:
  struct Texture {
    std::size_t pattern = 0;
    float contrast = 0;
    float relative_contrast = 0;  ///< on pictures
    float per_m = 1;              ///< tiles
  };
  void add_samples(const MipMap& map, const PlanarMap& to_uv, float scale, float texels_per_m, const LanePoints& p,
                   const PixelFootprint& footprint, Lanes& values) const;

  std::vector<MipMap> patterns_;
  std::vector<Texture> textures_;  ///< of the world
  std::vector<MipMap> pictures_;   ///< of the mesh
};

}  // namespace arpent::sim
