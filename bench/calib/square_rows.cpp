// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <filesystem>
#include <string>

#include "bench/calib/rows.h"
#include "calib/output.h"
#include "calib/stereo.h"
#include "common/atomic_file.h"
#include "tests/calib/board_picture.h"
#include "tests/calib/simulated_views.h"
#include "tools/mission/figures.h"

namespace arpent::bench {
namespace {

namespace fs = std::filesystem;
const fs::path kConfig = ARPENT_SOURCE_DIR "/config";
constexpr int kSeeds = 3;

/// Forty pairs of pictures of a board, corners found, calibrated: what a user of the true rig would have.
RigConfig calibrate_by_pictures(const Rig& truth) {
  const sim::CameraModel left(truth.calibration.left), right(truth.calibration.right);
  const calib::BoardDetector detector(calib::Target{});
  calib::BoardViews views{
      {}, {{"left", left.width_px(), left.height_px()}, {"right", left.width_px(), left.height_px()}}, {}};
  std::uint64_t seed = 0;
  for (const Pose& T_left_board : calib::simulated_boards({}, 7)) {
    const Pose T_right_board = truth.calibration.T_right_left * T_left_board;
    const auto a = detector.detect(calib::draw_board({}, left, T_left_board, seed++));
    const auto b = detector.detect(calib::draw_board({}, right, T_right_board, seed++));
    views.views.push_back({std::to_string(seed), {a, b}});
  }
  return calib::to_rig_config(calib::to_stereo(calib::calibrate(views).rig), truth.config);
}

double median_ate_m(const fs::path& rig, const fs::path& scratch) {
  std::vector<double> ate_m;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    tools::MissionOverrides overrides;
    overrides.seed = seed;
    overrides.rig = rig;
    tools::MissionOptions options;
    options.out = scratch / std::to_string(seed);
    options.progress = false;
    const auto result = tools::run_mission(tools::load_mission(kConfig / "missions/square.yaml", overrides), options);
    fs::remove_all(options.out);
    ate_m.push_back(result.done() ? tools::measure(result).ate_m : 1e3);
  }
  return median(ate_m);
}

}  // namespace

void add_square_rows(Report& report) {
  const fs::path scratch = fs::temp_directory_path() / ("arpent_calib_" + std::to_string(getpid()));
  fs::create_directories(scratch);
  const Rig truth = load_rig(kConfig / "rigs/wifibot_stereo.yaml");
  atomic_write(scratch / "rig.yaml", config::to_yaml(calibrate_by_pictures(truth)));
  const double true_m = median_ate_m({}, scratch), calibrated_m = median_ate_m(scratch / "rig.yaml", scratch);
  fs::remove_all(scratch);
  report.add("square.ate_true_m", true_m, "m", "median of 3 seeds");
  report.add("square.ate_calibrated_m", calibrated_m, "m");
  report.add("square.ate_ratio_calibrated", calibrated_m / true_m, "1", "bar <= 1.1");
}

}  // namespace arpent::bench
