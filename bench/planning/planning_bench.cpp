// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `planning`: incomplete surface and viewpoints.
#include "bench/harness.h"
#include "bench/planning/viewpoint_rows.h"

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "Planning",
                            [](arpent::bench::Report& report) { arpent::bench::viewpoint_rows(report); });
}
