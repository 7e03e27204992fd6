// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The part of a report that tells what the processes did: CPU time of each handler, and all counters.
#pragma once

#include <map>
#include <string>

#include "tools/report/html.h"
#include "tools/stack/process_figures.h"

namespace arpent::report {

void add_processes(Page& page, const std::map<std::string, tools::ProcessFigures>& processes);

}  // namespace arpent::report
