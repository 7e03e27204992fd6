// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `missions`: the thesis' Table 5.4 for one robot, with our columns for both presets.
#include <fmt/format.h>

#include <array>

#include "bench/system/mission_trials.h"

namespace arpent {
namespace {

struct Line {
  const char* place;
  const char* file;
  const char* thesis;  ///< coverage [%], RMSE [cm], time [s], path [m] of Table 5.4
};
constexpr std::array kLines{Line{"arena_1", "test_arena", "thesis 85.6 %, 4.00 cm, 173 s, 20.6 m"},
                            Line{"lot_1", "parking_lot", "thesis 89.1 %, 8.37 cm, 836 s, 106 m"}};
constexpr int kSeeds = 3;

void measure(bench::Report& report) {
  for (const Line& line : kLines) {
    for (const char* preset : {"default", "thesis"}) {
      std::vector<bench::Trial> trials(kSeeds);
      for (int i = 0; i < kSeeds; ++i) {
        bench::Trial& trial = trials[static_cast<std::size_t>(i)];
        trial.mission = fmt::format("{}/config/missions/{}.yaml", ARPENT_SOURCE_DIR, line.file);
        trial.overrides.seed = i + 1;
        trial.overrides.preset = preset;
      }
      bench::add_mission_rows(report, fmt::format("missions.{}.{}", line.place, preset), bench::run_trials(trials),
                              {{"coverage_percent", "%", line.thesis},
                               {"rmse_cm", "cm", ""},
                               {"time_s", "s", ""},
                               {"path_m", "m", ""},
                               {"duty_cycle_percent", "%", ""},
                               {"collisions", "1", ""},
                               {"done", "1", ""}});
    }
  }
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  using namespace arpent;
  return bench::run(argc, argv, "Table 5.4, one robot", [](bench::Report& report) { measure(report); });
}
