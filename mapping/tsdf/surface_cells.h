// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A depth image as a mosaic of small planes. Over a few pixels a surface is nearly flat, and a plane's inverse depth is
// linear in the pixel, with a noise that is the same everywhere: so each cell of 4 x 4 pixels gets the plane that fits
// the inverse depths around it. The map is fused from distances to these planes: true distances across the surface,
// whatever the angle of view, with the noise of many pixels averaged.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/stereo/depth_map.h"

namespace arpent::mapping {

inline constexpr int kCellPx = 4;

enum class CellKind : std::uint8_t {
  kNone = 0,   ///< nothing measured
  kPlane = 1,  ///< `normal . p + offset` is the distance of p to the surface, positive on the camera's side
  kEdge = 2,   ///< depths that no plane fits: an edge, clutter; ask the pixels
};

struct Cell {
  float nx = 0, ny = 0, nz = 0;  ///< unit normal, towards the camera, in the camera's frame
  float offset_m = 0;
};

struct SurfaceCells {
  int cols = 0;
  int rows = 0;
  std::vector<Cell> planes;
  std::vector<CellKind> kinds;
  std::vector<float> most_m;  ///< per cell, the greatest depth over the cell; 0 if nothing was measured
  [[nodiscard]] std::size_t at(int cell_u, int cell_v) const {
    return static_cast<std::size_t>(cell_v * cols + cell_u);
  }
};

/// `depth`: only pixels with finite depth in [min_range_m, max_range_m] count.
[[nodiscard]] SurfaceCells fit_surface_cells(const stereo::DepthMap& depth, double min_range_m, double max_range_m);

}  // namespace arpent::mapping
