// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Explores one world in the closed loop of bench `planning`, with a line per plan: WORLD.yaml or random:SEED, r_v [m].
#include <algorithm>
#include <cstdio>
#include <string>

#include "bench/harness.h"
#include "bench/planning/exploration_loop.h"
#include "common/error.h"
#include "sim/world/random_world.h"

namespace {

arpent::sim::World load(const std::string& name) {
  const std::string random = "random:";
  if (!name.starts_with(random)) return arpent::sim::load_world(name);
  return arpent::sim::make_random_world(static_cast<std::uint32_t>(std::stoul(name.substr(random.size()))));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: explore_loop WORLD.yaml|random:SEED VOXEL_M [LONGEST_S [MIN_VIEWPOINT_M2]]\n");
    return 2;
  }
  try {
    arpent::bench::LoopParams params;
    params.voxel_m = std::stod(argv[2]);
    if (argc > 3) params.longest_s = std::stod(argv[3]);
    if (argc > 4) params.viewpoints.min_viewpoint_m2 = std::stod(argv[4]);
    params.progress = true;
    const auto result = arpent::bench::explore(load(argv[1]), params);
    auto total = result.total_ms;
    std::sort(total.begin(), total.end());
    std::printf(
        "%s: %.1f s, %.1f m, %d visits, %d back-offs, %zu plans, %zu left, %zu completable, known %zu; plan median "
        "%.1f p95 %.1f max %.1f ms, targets median %.1f, note_look %.2f ms\n",
        result.finished ? "finished" : "NOT finished", result.time_s, result.path_m, result.visits, result.back_offs,
        total.size(), result.elements_left, result.completable_left, result.known_voxels, total[total.size() / 2],
        total[total.size() * 95 / 100], total.back(), arpent::bench::median(result.targets_ms),
        arpent::bench::median(result.note_look_ms));
    return result.finished ? 0 : 1;
  } catch (const arpent::InputError& error) {
    std::fprintf(stderr, "explore_loop: %s\n", error.what());
    return 2;
  }
}
