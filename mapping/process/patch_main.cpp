// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The patch_process executable.
#include "common/process/process.h"
#include "mapping/process/patch_process.h"

int main(int argc, char** argv) {
  return arpent::run_process<arpent::PatchProcess>(argc, argv);
}
