// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Rows of bench `planning` about incomplete surface and viewpoints, on the room of bench `tsdf`.
#pragma once

#include "bench/harness.h"

namespace arpent::bench {

void viewpoint_rows(Report& report);

}  // namespace arpent::bench
