// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Rows `plan.*` and `loop.*`: the parking lot explored in a closed loop, and how long its plans took.
#pragma once

#include "bench/harness.h"

namespace arpent::bench {

void exploration_rows(Report& report);

}  // namespace arpent::bench
