// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/process/process.h"
#include "link/process/team_link_process.h"

int main(int argc, char** argv) {
  return arpent::run_process<arpent::TeamLinkProcess>(argc, argv);
}
