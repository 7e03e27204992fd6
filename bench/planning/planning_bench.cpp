// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `planning`: one function of rows per part of the room.
#include "bench/harness.h"
#include "bench/planning/exploration_rows.h"
#include "bench/planning/local_rows.h"
#include "bench/planning/tour_rows.h"
#include "bench/planning/viewpoint_rows.h"

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "Planning", [](arpent::bench::Report& report) {
    arpent::bench::tour_rows(report);
    arpent::bench::viewpoint_rows(report);
    arpent::bench::exploration_rows(report);
    arpent::planning::local_rows(report);
  });
}
