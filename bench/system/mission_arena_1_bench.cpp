// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `mission_arena_1`: one robot reconstructs the test arena, images in the loop, preset default, 3 seeds.
#include "bench/system/mission_trials.h"

int main(int argc, char** argv) {
  using namespace arpent;
  return bench::run(argc, argv, "One robot in the test arena", [](bench::Report& report) {
    bench::measure_mission(report, "mission_arena_1", ARPENT_SOURCE_DIR "/config/missions/test_arena.yaml", 3,
                           {{"coverage_percent", "bar >= 95 (thesis 85.6)"},
                            {"rmse_cm", "bar <= 3 (4.00)"},
                            {"time_s", "bar <= 100 (173)"},
                            {"path_m", "bar <= 20 (20.6)"}});
  });
}
