// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The depth_process executable.
#include "common/process/process.h"
#include "perception/process/depth_process.h"

int main(int argc, char** argv) {
  return arpent::run_process<arpent::DepthProcess>(argc, argv);
}
