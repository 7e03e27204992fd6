// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The imu_process executable.
#include "common/process/process.h"
#include "drivers/imu/process/imu_process.h"

int main(int argc, char** argv) {
  return arpent::run_process<arpent::ImuProcess>(argc, argv);
}
