// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Draws worlds that nobody has tuned anything to: a room with pillars, boxes, interior walls, its own textures and
// lamps, a tag cube and starts around it that see it.
#pragma once

#include <cstdint>

#include "sim/world/world.h"

namespace arpent::sim {

/// The same seed gives the same world. Every world is sound (check_world), its free floor is in one piece for a robot
/// 0.7 m wide, and it has at least two starts: 0.8 m from every obstacle, looking at the tag cube 1.2 to 2 m away.
[[nodiscard]] World make_random_world(std::uint32_t seed);

}  // namespace arpent::sim
