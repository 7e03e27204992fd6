// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/process/process.h"
#include "planning/process/centre_process.h"

int main(int argc, char** argv) {
  return arpent::run_process<arpent::CentreProcess>(argc, argv);
}
