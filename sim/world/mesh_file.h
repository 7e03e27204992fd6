// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Mesh files of a world, through assimp: triangles in world coordinates, their pictures as grey reflectance.
#pragma once

#include "sim/world/world.h"

namespace arpent::sim {

/// Loads `shape.file` (relative: under $ARPENT_DATA/worlds), applies scale, yaw and translation in this order. Coplanar
/// twins of opposite sides are kept once, the pictured one first. COLLADA is turned back to z up. Throws InputError: no
/// ARPENT_DATA, no such file, no triangles, numbers that are not finite, a picture that cannot be read.
[[nodiscard]] std::shared_ptr<const MeshData> load_mesh(const MeshShape& shape);

}  // namespace arpent::sim
