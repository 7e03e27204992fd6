// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The odometry_process executable.
#include "common/process/process.h"
#include "perception/process/odometry_process.h"

int main(int argc, char** argv) {
  return arpent::run_process<arpent::OdometryProcess>(argc, argv);
}
