// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/process/sim_process.h"

#include <algorithm>
#include <arpent/pose_t.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/config/robot.h"
#include "common/ellipse.h"
#include "common/error.h"
#include "common/split.h"
#include "drivers/base/agilex_chassis.h"
#include "drivers/can/process/open_can_port.h"
#include "sim/camera/depth_sensor.h"
#include "sim/camera/renderer.h"
#include "sim/process/truth_socket.h"
#include "sim/robot/sim_robot.h"
#include "sim/wire.h"
#include "sim/world/ground.h"
#include "sim/world/world.h"

namespace arpent {
namespace {

/// The chassis' own cycle; wheels, inertial unit and truth go by it.
constexpr Duration kCycle = std::chrono::milliseconds(20);
constexpr double kCycleS = 0.02;
constexpr int kSubsteps = 4;
/// Live, a machine that is slower than real time: what it is behind beyond this is lost, and the world stands
/// meanwhile.
constexpr Duration kMostBehind = std::chrono::milliseconds(500);
/// By so much a cycle may be early: a timer that came late once does not hold back all that follow.
constexpr Duration kMostAhead = std::chrono::milliseconds(2);
/// An obstacle appears where the robot is at least so far away.
constexpr double kObstacleApartM = 0.9;
const char* const kObstacle = "(obstacle)";
/// What the alignment of `sensing: depth` is worth, as tags at 2 m are (bench `square`).
constexpr double kAlignmentSigmaM = 0.004;
constexpr double kAlignmentSigmaRad = 0.002;
constexpr std::int64_t kAlignmentSequence = 3;

std::uint64_t seed_of(int seed, std::uint64_t what) {
  return static_cast<std::uint64_t>(seed) * 1000003 + what;
}

base::ChassisParams chassis_of(const SimConfig& config, const RobotConfig& robot) {
  base::ChassisParams params{.motors = config.motors};
  params.motors.geometry = robot.base.geometry;
  params.motors.geometry.track_m *= 1 + config.track_error;
  return params;
}

/// The velocity of the left camera in its own axes while the body moves on the ground.
Vector6d camera_twist(const Twist2& body, const Pose& T_body_cam) {
  const Eigen::Vector3d turn(0, 0, body.turn_rate_radps);
  const Eigen::Vector3d linear = Eigen::Vector3d(body.speed_mps, 0, 0) + turn.cross(T_body_cam.translation());
  const Eigen::Matrix3d R_cam_body = T_body_cam.linear().transpose();
  Vector6d twist;
  twist.head<3>() = R_cam_body * linear;
  twist.tail<3>() = R_cam_body * turn;
  return twist;
}

}  // namespace

struct SimProcess::State {
  Config config;
  Bus& bus;
  Clock& clock;
  sim::World world;
  sim::GroundMap ground;
  sim::Renderer renderer;
  RobotConfig robot_config;
  Rig rig;
  sim::CameraModel left, right;
  std::unique_ptr<can::CanPort> port;
  base::AgilexChassis chassis;
  sim::SimRobot robot;
  sim::SimImu imu;
  sim::SimOdometry odometry;
  camera::ExposureController exposure;
  std::int64_t cycle = 0, pair = 0;
  Time due{};  ///< of the next cycle
  std::int64_t cycles_per_pair = 10;
  /// What the cameras have taken and not yet handed over.
  std::vector<std::pair<std::string, Bytes>> in_transfer;
  std::optional<Pose> T_odom_last;
  std::mt19937_64 alignment_random;
  std::map<std::string, Pose2> teammates;  ///< as they last said, a cycle ago
  std::unique_ptr<TruthSocket> truth;      ///< nullptr: teammates are on the bus

  State(const Config& c, Bus& process_bus, Clock& process_clock)
      : config(c),
        bus(process_bus),
        clock(process_clock),
        world(sim::load_world(c.world)),
        ground(world),
        renderer(world),
        robot_config(config::load<RobotConfig>(c.robot)),
        rig(load_rig(robot_config.rig)),
        left(rig.calibration.left),
        right(rig.calibration.right),
        port(can::open_can_port(c.can, "chassis", process_bus, process_clock)),
        chassis(chassis_of(c, robot_config), *port),
        robot(sim::start_of(world, c.start), [this](const Pose2& pose) { return touches(pose); }),
        imu(c.imu, seed_of(c.seed, 1)),
        odometry(c.odometry, seed_of(c.seed, 2)),
        exposure(c.exposure),
        alignment_random(seed_of(c.seed, 3)) {
    cycles_per_pair = std::max<std::int64_t>(1, std::llround(1 / (rig.config.rate_hz * kCycleS)));
  }

  [[nodiscard]] bool touches(const Pose2& pose) const {
    const double a = robot_config.semi_axis_long_m, b = robot_config.semi_axis_short_m;
    return ground.hits(pose, {a, b}) || std::any_of(teammates.begin(), teammates.end(), [&](const auto& mate) {
             return ellipses_overlap(a, b, pose, mate.second);
           });
  }

  void listen_to_teammates() {
    const std::vector<std::string> names = split(config.teammates, ',');
    if (!config.truth_folder.empty()) {
      if (config.name.empty()) throw InputError("truth_folder needs the robot's name");
      truth = std::make_unique<TruthSocket>(config.truth_folder, config.name, names);
      return;
    }
    for (const std::string& name : names) {
      subscribe<pose_t>(bus, name + "/" + channels::kTruthPose, {.queue_capacity = 4},
                        [this, name](const pose_t& m) { note(name, m); });
    }
  }

  void note(const std::string& teammate, const pose_t& m) {
    const double* q = m.orientation_wxyz;
    const auto T = make_pose(Eigen::Map<const Eigen::Vector3d>(m.position_m), {q[0], q[1], q[2], q[3]});
    if (T) teammates[teammate] = to_pose2(*T);
  }

  /// Of the cycle before, as on the bus.
  void hear_teammates() {
    if (!truth) return;
    truth->receive([this](const std::string& teammate, BytesView bytes) {
      pose_t message;
      std::string fault;
      if (decode_guarded(bytes, message, fault)) note(teammate, message);
    });
  }

  [[nodiscard]] std::vector<sim::Body> bodies() const {
    std::vector<sim::Body> bodies;
    for (const auto& [name, pose] : teammates) bodies.push_back({pose.to_pose()});
    return bodies;
  }

  /// Lockstep: one cycle. Live, a timer comes late now and then; hardware does not. So cycles keep to their own times,
  /// and those that are due are made up for.
  void tick() {
    const Time now = clock.now();
    if (cycle == 0 || now - due > kMostBehind || (now < due && due - now < kMostAhead)) due = now;
    for (; due <= now; due += kCycle) step(due);
  }

  void step(Time now) {
    hand_over();
    hear_teammates();
    chassis.set_blocked(robot.in_contact());
    chassis.step(now, kCycleS);
    const Twist2 pushed = chassis.twist();
    drive(pushed);
    // A reading is the mean of the cycle that ends now, and of its middle.
    publish(bus, channels::kImu, sim::to_wire(now - kCycle / 2, cycle, imu.read(robot.twist(), kCycleS)));
    const pose_t here = sim::to_wire(now, robot.pose());
    publish(bus, channels::kTruthPose, here);
    if (truth) truth->send(encode(here));
    put_obstacle();
    if (cycle++ % cycles_per_pair != 0) return;
    if (within(config.faults.silent_at_s, config.faults.silent_s)) {
      ++pair;
      return;
    }
    if (config.sensing == "images") {
      take_images(now);
    } else {
      take_depth(now);
    }
    ++pair;
  }

  /// Whether a fault that begins `at_s` after the start lasts.
  [[nodiscard]] bool within(double at_s, double lasts_s) const {
    const double now_s = static_cast<double>(cycle) * kCycleS;
    return at_s >= 0 && now_s >= at_s && now_s < at_s + lasts_s;
  }
  [[nodiscard]] bool is_blind() const { return within(config.faults.blind_at_s, config.faults.blind_s); }

  void put_obstacle() {
    if (!within(config.faults.obstacle_at_s, 1e9) || teammates.contains(kObstacle)) return;
    const std::vector<double>& at = config.faults.obstacle;
    const Pose2 place{at[0], at[1], at[2]};
    if ((place.position_m() - robot.pose().position_m()).norm() >= kObstacleApartM) teammates[kObstacle] = place;
  }

  void drive(const Twist2& pushed) {
    const int before = robot.collisions();
    for (int i = 0; i < kSubsteps; ++i) robot.step(pushed, kCycleS / kSubsteps);
    if (robot.collisions() == before) return;
    bus.health().count("WORLD", "collision", robot.collisions() - before);
    bus.health().warn("the robot touches something");
  }

  /// Readout and transfer take a cycle.
  void hand_over() {
    for (const auto& [channel, bytes] : in_transfer) bus.publish_bytes(channel, bytes);
    in_transfer.clear();
  }

  template <class Message>
  void transfer(const char* channel, const Message& message) {
    in_transfer.emplace_back(channel, encode(message));
  }

  sim::CameraImage take(const sim::CameraModel& camera, const Pose& T_body_cam, std::uint64_t which) const {
    sim::CameraShot shot;
    shot.twist_cam = camera_twist(robot.twist(), T_body_cam);
    shot.exposure_s = 1e-6 * exposure.setting().exposure_us;
    shot.gain = std::pow(10, exposure.setting().gain_db / 20);
    shot.seed = seed_of(config.seed, 16 + 2 * static_cast<std::uint64_t>(pair) + which);
    return renderer.render(camera, robot.pose().to_pose() * T_body_cam, shot, bodies());
  }

  void take_images(Time now) {
    const Pose& T_body_left = rig.calibration.T_body_left;
    cv::Mat1b left_image = take(left, T_body_left, 0).image;
    cv::Mat1b right_image = take(right, T_body_left * rig.calibration.T_right_left.inverse(), 1).image;
    if (is_blind()) left_image = right_image = cv::Mat1b(left_image.size(), 0);
    const camera::ExposureSetting setting = exposure.setting();
    transfer(channels::kStereoImages, sim::to_wire(now, pair, setting, left_image, right_image));
    (void)exposure.update(setting, 0.5 * (cv::mean(left_image)[0] + cv::mean(right_image)[0]));
  }

  void take_depth(Time now) {
    const PinholeCamera& camera = rig.calibration.left.pinhole;
    sim::DepthNoise noise;
    noise.focal_px = camera.fx_px;
    noise.baseline_m = rig.calibration.T_right_left.translation().norm();
    noise.min_range_m = rig.config.min_range_m;
    const Pose T_world_left = robot.pose().to_pose() * rig.calibration.T_body_left;
    const cv::Mat1f exact_m = renderer.depth_m(left, T_world_left, bodies());
    const sim::NoisyDepth noisy =
        sim::sense_depth(exact_m, noise, seed_of(config.seed, 16 + static_cast<std::uint64_t>(pair)));
    if (!is_blind()) transfer(channels::kDepth, sim::to_wire(now, pair, camera, noisy.depth_m, noisy.sigma_m));
    const sim::SimulatedStep step = odometry.move_to(robot.pose());
    const Pose T_last_now = T_odom_last.value_or(step.T_odom_body).inverse() * step.T_odom_body;
    const double duration_s = T_odom_last ? static_cast<double>(cycles_per_pair) * kCycleS : 0.0;
    odometry_t message = sim::to_wire(now, pair, step, T_last_now, duration_s);
    if (is_blind()) message.status = odometry_t::STATUS_LOST;
    transfer(channels::kOdometry, message);
    T_odom_last = step.T_odom_body;
    if (pair == kAlignmentSequence) align(now, step.T_odom_body);
  }

  void align(Time now, const Pose& T_odom_body) {
    std::normal_distribution<double> normal;
    Vector6d error = Vector6d::Zero();
    error(0) = kAlignmentSigmaM * normal(alignment_random);
    error(1) = kAlignmentSigmaM * normal(alignment_random);
    error(5) = kAlignmentSigmaRad * normal(alignment_random);
    const Pose T_world_odom = retract(robot.pose().to_pose(), error) * T_odom_body.inverse();
    transfer(channels::kFrameAlignment, sim::to_wire(now, T_world_odom, kAlignmentSigmaM, kAlignmentSigmaRad));
  }
};

SimProcess::SimProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  state_->listen_to_teammates();
  clock.every(kCycle, [this] { state_->tick(); });
}

SimProcess::~SimProcess() = default;

int SimProcess::collisions() const {
  return state_->robot.collisions();
}

}  // namespace arpent
