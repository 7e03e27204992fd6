// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Rows of bench `planning` for planning/local: prices of all clusters, legs, the ground's upkeep, the stop guard.
#pragma once

#include "bench/harness.h"

namespace arpent::planning {

void local_rows(bench::Report& report);

}  // namespace arpent::planning
