// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The mapping_process executable.
#include "common/process/process.h"
#include "mapping/process/mapping_process.h"

int main(int argc, char** argv) {
  return arpent::run_process<arpent::MappingProcess>(argc, argv);
}
