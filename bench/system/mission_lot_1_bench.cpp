// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `mission_lot_1`: one robot reconstructs the parking lot, images in the loop, preset default, 3 seeds.
#include "bench/system/mission_trials.h"

int main(int argc, char** argv) {
  using namespace arpent;
  return bench::run(argc, argv, "One robot in the parking lot", [](bench::Report& report) {
    bench::measure_mission(report, "mission_lot_1", ARPENT_SOURCE_DIR "/config/missions/parking_lot.yaml", 3,
                           {{"coverage_percent", "bar >= 93 (thesis 89.1)"},
                            {"rmse_cm", "bar <= 5 (8.37)"},
                            {"time_s", "bar <= 450 (836)"},
                            {"path_m", "bar <= 95 (106)"},
                            {"duty_cycle_percent", "bar >= 50"},
                            {"realtime_factor", "bar >= 1; one core"}});
  });
}
