// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace arpent::tools {

/// What a process knows of itself at the end of a run.
struct ProcessFigures {
  std::map<std::string, std::int64_t> counters;
  std::map<std::string, std::vector<double>> handler_ms;
  std::vector<std::pair<std::string, std::int64_t>> messages;
};

}  // namespace arpent::tools
