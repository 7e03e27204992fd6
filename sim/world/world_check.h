// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Faults of a world as a whole, which no single key can tell.
#pragma once

#include "sim/world/node_reader.h"
#include "sim/world/world.h"

namespace arpent::sim {

/// `start_lines`: where in the file each start stands.
void check_world(const World& world, const std::vector<int>& start_lines, Faults& faults);

}  // namespace arpent::sim
