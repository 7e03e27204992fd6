// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// sim_process: the hardware that is not there. A robot in a simulated world: its chassis listens and answers on the CAN
// bus, its cameras and its inertial unit publish what real ones would. Nothing above it can tell, but for TRUTH_POSE,
// which is for evaluation alone.
//
// With `sensing: depth` it stands in for perception as well: DEPTH with the noise of the thesis' numerical experiments,
// ODOMETRY that drifts, one FRAME_ALIGNMENT. Missions that are about planning run ten times as fast this way.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "drivers/base/wheel_motors.h"
#include "drivers/camera/exposure_controller.h"
#include "sim/robot/sim_imu.h"
#include "sim/robot/sim_odometry.h"

namespace arpent {

/// What goes wrong, for tests of what comes of it. A time below zero: it does not.
struct SimFaults {
  double silent_at_s = -1;
  double silent_s = 3;
  double blind_at_s = -1;
  double blind_s = 5;
  double obstacle_at_s = -1;
  std::vector<double> obstacle{0, 0, 0};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("silent_at_s", self.silent_at_s, "the cameras send nothing from then on, after the start",
                  config::between(-1.0, 1e6));
    visitor.field("silent_s", self.silent_s, "for so long", config::at_least(0.0));
    visitor.field("blind_at_s", self.blind_at_s, "images are black from then on; sensing depth: odometry is lost",
                  config::between(-1.0, 1e6));
    visitor.field("blind_s", self.blind_s, "for so long", config::at_least(0.0));
    visitor.field("obstacle_at_s", self.obstacle_at_s,
                  "something of a robot's size stands in the world from then on, once the place is free",
                  config::between(-1.0, 1e6));
    visitor.field("obstacle", self.obstacle, "where: x, y, yaw in the world", config::finite_numbers(3));
  }
};

struct SimConfig {
  std::filesystem::path world;
  std::filesystem::path robot;
  int start = 0;
  int seed = 1;
  std::string sensing = "images";
  std::string can = "bus";
  std::string teammates;
  std::string name;
  std::filesystem::path truth_folder;
  base::MotorParams motors{.left_slip = 0.01, .right_slip = 0.01};
  double track_error = 0.01;
  camera::ExposureParams exposure;
  sim::ImuNoise imu;
  sim::OdometryNoise odometry;
  SimFaults faults;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("world", self.world, "world file (docs/worlds.md)", config::required_path());
    visitor.field("robot", self.robot, "robot file", config::required_path());
    visitor.field("start", self.start, "which of the world's starts, from 0", config::at_least(0));
    visitor.field("seed", self.seed, "seed of all noise", config::at_least(0));
    visitor.field("sensing", self.sensing, "images: cameras; depth: depth and odometry, for missions about planning",
                  config::one_of({"images", "depth"}));
    visitor.field("can", self.can, "the chassis' place on the CAN bus: bus (messages on channel CAN) or socket:PATH");
    visitor.field("teammates", self.teammates,
                  "names of other robots in this world, with commas between: their TRUTH_POSE says where they stand");
    visitor.field("name", self.name, "the robot's own name, for truth_folder");
    visitor.field(
        "truth_folder", self.truth_folder,
        "folder of the local sockets on which simulators in processes of their own tell each other TRUTH_POSE; "
        "empty: it comes on the bus");
    visitor.group("motors", self.motors, "motors and wheels; their geometry is the robot file's");
    visitor.field("track_error", self.track_error, "by how much the effective track is wider than the robot file says",
                  config::between(-0.5, 0.5));
    visitor.group("exposure", self.exposure, "exposure of both cameras");
    visitor.group("imu", self.imu, "the inertial unit");
    visitor.group("odometry", self.odometry, "drift of the odometry that `sensing: depth` gives");
    visitor.group("faults", self.faults, "what goes wrong, on purpose");
  }
};

class SimProcess {
 public:
  using Config = SimConfig;
  static constexpr char kName[] = "sim_process";
  static constexpr char kHelp[] = "Simulates a robot in a world: CAN chassis, stereo cameras, inertial unit.";

  /// Throws InputError for a world or a robot that cannot be used.
  SimProcess(const Config& config, Bus& bus, Clock& clock);
  ~SimProcess();

  void finish() {}
  [[nodiscard]] int collisions() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
