// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `sim`: CPU time of one rendered 640x512 stereo pair with everything on (noise, motion blur, edges), in the test
// arena and in the parking lot with seven teammates in the world, and of building a world.
#include <opencv2/core.hpp>

#include "bench/harness.h"
#include "common/config/rig.h"
#include "sim/camera/renderer.h"

namespace arpent {
namespace {

using sim::Body;
using sim::CameraModel;
using sim::Renderer;

/// Poses of a slow drive in a circle, so that no run sees the same picture twice.
Pose2 pose_on_circle(int i, double x_m, double y_m) {
  const double angle = 0.7 * i;
  return {x_m + 0.4 * std::cos(angle), y_m + 0.4 * std::sin(angle), angle};
}

void add_pair(bench::Report& report, const std::string& name, const Renderer& renderer, const StereoCalibration& rig,
              const Eigen::Vector2d& centre_m, const std::vector<Body>& bodies, const std::string& note) {
  const CameraModel left(rig.left), right(rig.right);
  sim::CameraShot shot;
  shot.twist_cam << 0, 0, 0.5, 0, 1.0, 0;  // nominal speed, highest turn rate
  int i = 0;
  report.add_time(
      name,
      [&] {
        const Pose T_world_left = pose_on_circle(++i, centre_m.x(), centre_m.y()).to_pose() * rig.T_body_left;
        shot.seed += 2;
        (void)renderer.render(left, T_world_left, shot, bodies);
        ++shot.seed;
        (void)renderer.render(right, T_world_left * rig.T_right_left.inverse(), shot, bodies);
      },
      15, note);
}

void body(bench::Report& report) {
  const std::string config = ARPENT_SOURCE_DIR "/config/";
  const StereoCalibration rig = load_rig(config + "rigs/wifibot_stereo.yaml").calibration;
  const sim::World arena = sim::load_world(config + "worlds/test_arena.yaml");
  const sim::World lot = sim::load_world(config + "worlds/parking_lot.yaml");
  add_pair(report, "sim.render_pair_ms", Renderer(arena), rig, {2.0, 3.5}, {}, "bar: at most 1 x ref");
  std::vector<Body> team;
  for (int i = 0; i < 7; ++i) team.push_back({Pose2{2.0 + 2.5 * i, 5.0 + 0.6 * i, 0.9 * i}.to_pose()});
  add_pair(report, "sim.render_pair_lot_team_ms", Renderer(lot), rig, {4.0, 5.8}, team, "seven teammates");
  report.add_time(
      "sim.build_world_ms", [&] { (void)Renderer(lot); }, 5, "parking lot: textures, light");
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "Simulated cameras", arpent::body);
}
