// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/report/processes.h"

#include <fmt/format.h>

#include <algorithm>

namespace arpent::report {
namespace {

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

}  // namespace

void add_processes(Page& page, const std::map<std::string, tools::ProcessFigures>& processes) {
  page.section("Processes", "CPU time of each handler, and what was counted.");
  std::vector<std::vector<std::string>> timings, counts;
  for (const auto& [name, figures] : processes) {
    for (const auto& [channel, ms] : figures.handler_ms) {
      timings.push_back({name, channel, std::to_string(ms.size()), fmt::format("{:.1f}", percentile(ms, 0.5)),
                         fmt::format("{:.1f}", percentile(ms, 0.95)), fmt::format("{:.1f}", percentile(ms, 1.0))});
    }
    for (const auto& [counter, value] : figures.counters) counts.push_back({name, counter, std::to_string(value)});
  }
  page.table({"process", "input", "calls", "median [ms]", "p95 [ms]", "max [ms]"}, timings);
  page.table({"process", "counter", "value"}, counts);
}

}  // namespace arpent::report
