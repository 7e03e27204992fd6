// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/planning/exploration_rows.h"

#include <algorithm>

#include "bench/planning/exploration_loop.h"

namespace arpent::bench {
namespace {

constexpr int kReferences = 7;

double p95(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() * 95 / 100];
}

}  // namespace

void exploration_rows(Report& report) {
  std::vector<double> reference_ms;
  for (int i = 0; i < kReferences; ++i) reference_ms.push_back(time_reference_once());
  const LoopResult lot = explore(sim::load_world(ARPENT_WORLDS "/parking_lot.yaml"), {.voxel_m = 0.2});
  for (int i = 0; i < kReferences; ++i) reference_ms.push_back(time_reference_once());
  const double reference = median(reference_ms);
  report.add("plan.total_ms_median", median(lot.total_ms), "ms", "changed map to new tour and first leg, lot");
  report.add("plan.total_ms_p95", p95(lot.total_ms), "ms");
  report.add("plan.total_ms_p95_over_ref", p95(lot.total_ms) / reference, "1", "bar <= 2.5");
  report.add("plan.targets_ms_p95", p95(lot.targets_ms), "ms", "of these: viewpoints, clusters, certificates");
  report.add("plan.note_look_ms_median", median(lot.note_look_ms), "ms", "per depth image");
  report.add("loop.lot_finished", lot.finished ? 1 : 0, "1", "nothing left that a viewpoint could complete");
  report.add("loop.lot_time_s", lot.time_s, "s", "exact depth and motion");
  report.add("loop.lot_path_m", lot.path_m, "m");
  report.add("loop.lot_visits", lot.visits, "1");
  report.add("loop.lot_back_offs", lot.back_offs, "1", "no leg led on");
  report.add("loop.lot_elements_left", static_cast<double>(lot.elements_left), "1");
  report.add("loop.lot_completable_left", static_cast<double>(lot.completable_left), "1");
}

}  // namespace arpent::bench
