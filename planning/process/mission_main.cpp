// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The mission_process executable.
#include "common/process/process.h"
#include "planning/process/mission_process.h"

int main(int argc, char** argv) {
  return arpent::run_process<arpent::MissionProcess>(argc, argv);
}
