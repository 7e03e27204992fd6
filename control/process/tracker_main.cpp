// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The tracker_process executable.
#include "common/process/process.h"
#include "control/process/tracker_process.h"

int main(int argc, char** argv) {
  return arpent::run_process<arpent::TrackerProcess>(argc, argv);
}
