// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The camera_process executable.
#include "common/process/process.h"
#include "drivers/camera/process/camera_process.h"

int main(int argc, char** argv) {
  return arpent::run_process<arpent::CameraProcess>(argc, argv);
}
