// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The rows of bench `planning` about tours: how far from the best, how fast, and which objective makes the better
// tours.
#pragma once

#include "bench/harness.h"

namespace arpent::bench {

void tour_rows(Report& report);

}  // namespace arpent::bench
