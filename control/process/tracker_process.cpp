// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "control/process/tracker_process.h"

#include <algorithm>
#include <arpent/estop_t.hpp>
#include <optional>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/robot.h"
#include "common/error.h"
#include "control/wire.h"

namespace arpent {
namespace {

using control::TrackerOutput;
using control::TrackerParams;

/// A base that has not spoken for longer, by the local clock, is not steered.
constexpr Duration kMaxBaseAge = std::chrono::milliseconds(500);
/// A pose may come early by this share of the period.
constexpr double kEarly = 0.1;

TrackerParams make_params(const TrackerConfig& config) {
  TrackerParams params = config.tracker;
  params.limits = config::load<RobotConfig>(config.robot).limits;
  return params;
}

}  // namespace

struct TrackerProcess::State {
  Config config;
  Bus& bus;
  Clock& clock;
  TrackerParams params;
  control::PathTracker tracker;
  std::optional<control::TrackedPose> pose;
  Time pose_received{};
  std::optional<Time> stepped;  ///< pose time of the last step
  std::optional<control::PathOrder> order;
  std::string stopped_by;  ///< emergency stop, until the next path
  std::string hindrance = "the base has not spoken yet";
  Time base_heard{};
  Twist2 commanded;

  State(const Config& process_config, Bus& process_bus, Clock& process_clock)
      : config(process_config), bus(process_bus), clock(process_clock), params(make_params(config)), tracker(params) {}

  void refuse(const char* channel, const std::string& fault) const {
    bus.health().count(channel, "invalid");
    bus.health().warn(std::string(channel) + ": message dropped: " + fault);
  }

  void send(const TrackerOutput& output) {
    if (!config.dry_run) publish(bus, channels::kWheelCommand, control::to_wire(output.command, pose->state.stamp));
    publish(bus, channels::kTrackerStatus, control::to_wire(output, pose->state.stamp, order ? order->sequence : -1));
    if (output.mode == control::TrackerMode::kBrake) bus.health().warn("brakes: " + output.reason);
    commanded = output.command;
  }

  /// Why the base must not drive now, empty if it may.
  [[nodiscard]] std::string find_obstacle() const {
    if (!stopped_by.empty()) return stopped_by;
    if (!order) return "";
    if (!hindrance.empty()) return hindrance;
    if (clock.now() - base_heard > kMaxBaseAge) return "the base is silent";
    if (pose->lost) return "the pose is lost: " + pose->reason;
    if (pose->frame != order->frame) return "the path is in " + order->frame + ", the pose in " + pose->frame;
    return "";
  }

  void on_pose(const body_pose_t& message) {
    auto read = control::from_wire(message);
    if (!read) return refuse(channels::kPose, read.fault());
    if (pose && read->state.stamp <= pose->state.stamp) {
      return refuse(channels::kPose, "its time is not after the last one's");
    }
    pose = std::move(*read);
    pose_received = clock.now();
    const Time now = pose->state.stamp;
    if (stepped && to_seconds(now - *stepped) < (1 - kEarly) * params.period_s) return;
    stepped = now;
    const std::string obstacle = find_obstacle();
    send(obstacle.empty() ? tracker.step(now, pose->state) : tracker.brake(now, obstacle));
  }

  /// Once a period by the clock.
  void watch() {
    if (!pose) return;
    const Duration age = clock.now() - pose_received;
    if (to_seconds(age) <= params.max_pose_age_s) return;
    // The pose's time, as it goes on.
    const Time now = std::max(pose->state.stamp + age, stepped.value_or(Time{}));
    stepped = now;
    send(tracker.brake(now, "the pose is stale"));
    if (commanded == Twist2{}) {
      // Stands: a pose of whatever time is a new beginning.
      tracker.halt();
      pose.reset();
      stepped.reset();
    }
  }

  void stop_following() {
    tracker.stop();
    order.reset();
  }

  void on_path(const path_t& message) {
    const auto read = control::from_wire(message);
    if (!read) {
      // The old path was to be replaced: it is not followed any more either.
      stop_following();
      return refuse(channels::kPath, read.fault());
    }
    if (order && read->stamp < order->stamp)
      return refuse(channels::kPath, "it is older than the one that is followed");
    if (read->points_m.empty()) return stop_following();
    control::Limits limits = params.limits;
    limits.max_speed_mps = std::min(limits.max_speed_mps, read->max_speed_mps.value_or(limits.max_speed_mps));
    try {
      tracker.follow(control::Path(read->points_m, limits), read->goal_heading_rad, read->backwards);
    } catch (const InputError& error) {
      stop_following();
      return refuse(channels::kPath, error.what());
    }
    order = *read;
    stopped_by.clear();
  }

  void on_estop(const estop_t& message) {
    stop_following();
    tracker.halt();
    stopped_by = "emergency stop by " + message.source + ": " + message.reason;
    if (pose) send(tracker.brake(stepped.value_or(pose->state.stamp), stopped_by));
  }

  void on_wheels(const wheel_state_t& message) {
    hindrance = control::find_hindrance(message);
    base_heard = clock.now();
  }
};

TrackerProcess::TrackerProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  State& state = *state_;
  SubscriptionOptions options;
  options.queue_capacity = 1;
  subscribe<path_t>(bus, channels::kPath, options, [&state](const path_t& message) { state.on_path(message); });
  subscribe<wheel_state_t>(bus, channels::kWheelState, options,
                           [&state](const wheel_state_t& message) { state.on_wheels(message); });
  options.queue_capacity = 8;
  subscribe<estop_t>(bus, channels::kEstop, options, [&state](const estop_t& message) { state.on_estop(message); });
  options.latency = Duration(config.latency_us);
  subscribe<body_pose_t>(bus, channels::kPose, options,
                         [&state](const body_pose_t& message) { state.on_pose(message); });
  clock.every(from_seconds(state.params.period_s), [&state] { state.watch(); });
}

TrackerProcess::~TrackerProcess() = default;

void TrackerProcess::finish() {
  State& state = *state_;
  if (state.pose && !state.config.dry_run) {
    publish(state.bus, channels::kWheelCommand, control::to_wire({}, state.pose->state.stamp));
  }
}

}  // namespace arpent
