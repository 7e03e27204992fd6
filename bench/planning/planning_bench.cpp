// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `planning`: what the parts of planning/ take.
#include "bench/harness.h"
#include "bench/planning/local_rows.h"

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "Planning", arpent::planning::local_rows);
}
