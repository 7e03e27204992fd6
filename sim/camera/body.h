// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The shape of a robot as others see it.
#pragma once

#include "sim/world/surface_mesh.h"

namespace arpent::sim {

/// Adds a Wifibot-like robot: chassis 0.60 x 0.32 m, four wheels, a mast and a bar with two lenses 0.40 m above ground.
void add_robot(SurfaceMesh& mesh, const Pose& T_world_body);

}  // namespace arpent::sim
