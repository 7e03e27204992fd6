// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The base_driver_process executable.
#include "common/process/process.h"
#include "drivers/base/process/base_driver_process.h"

int main(int argc, char** argv) {
  return arpent::run_process<arpent::BaseDriverProcess>(argc, argv);
}
