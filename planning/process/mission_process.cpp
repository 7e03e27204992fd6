// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/process/mission_process.h"

#include <arpent/body_pose_t.hpp>
#include <optional>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "perception/fusion/wire.h"
#include "planning/mission/lifecycle.h"
#include "planning/mission/path_progress.h"
#include "planning/wire.h"

namespace arpent {
namespace {

constexpr Duration kCycle = std::chrono::milliseconds(100);
constexpr int kCyclesPerReport = 10;
constexpr int kCyclesPerRequest = 10;
constexpr double kNominalSpeedMps = 0.5;

}  // namespace

using planning::MissionState;

struct MissionProcess::State {
  Config config;
  Bus& bus;
  Clock& clock;
  planning::Lifecycle life;
  std::optional<Time> started;
  std::optional<fusion::FusedPose> pose;
  std::optional<planning::BaseState> base;
  std::optional<planning::DriveReport> drive;
  std::vector<Eigen::Vector2d> loop;
  double loop_m = 0;
  std::int64_t path_sequence = 0;
  std::int64_t cycle = 0;
  MissionState reported = MissionState::kAborted;

  State(const Config& c, Bus& process_bus, Clock& process_clock) : config(c), bus(process_bus), clock(process_clock) {
    // A loop that cannot be driven is found at the start, not when the robot stands there.
    (void)planning::make_loop({}, c.loop);
  }

  template <class Message, class Take>
  void listen(const char* channel, int capacity, Take take) {
    subscribe<Message>(bus, channel, {.queue_capacity = capacity}, [this, channel, take](const Message& message) {
      take(message, [this, channel](const std::string& fault) {
        bus.health().count(channel, "invalid");
        bus.health().warn(std::string(channel) + ": message dropped: " + fault);
      });
    });
  }

  void listen_all() {
    listen<mission_command_t>(channels::kMissionCommand, 4, [this](const auto& message, const auto& refuse) {
      if (const auto order = planning::from_wire(message)) {
        obey(*order);
      } else {
        refuse(order.fault());
      }
    });
    listen<body_pose_t>(channels::kPose, 4, [this](const auto& message, const auto& refuse) {
      if (const auto decoded = fusion::from_wire(message)) {
        pose = *decoded;
      } else {
        refuse(decoded.fault());
      }
    });
    listen<wheel_state_t>(channels::kWheelState, 4, [this](const auto& message, const auto& refuse) {
      if (const auto decoded = planning::from_wire(message)) {
        base = *decoded;
      } else {
        refuse(decoded.fault());
      }
    });
    listen<tracker_status_t>(channels::kTrackerStatus, 4, [this](const auto& message, const auto& refuse) {
      if (const auto decoded = planning::from_wire(message)) {
        drive = *decoded;
      } else {
        refuse(decoded.fault());
      }
    });
  }

  void obey(const planning::MissionOrder& order) {
    if (const auto refused = life.command(order.command, order.source)) {
      bus.health().warn(*refused);
      return;
    }
    switch (order.command) {
      case planning::MissionCommand::kStart:
        started = clock.now();
        break;
      case planning::MissionCommand::kResume:
        if (life.state() == MissionState::kRunning) drive_on();
        break;
      case planning::MissionCommand::kPause:
      case planning::MissionCommand::kAbort:
        stop();
        break;
    }
    report();
  }

  void step() {
    ++cycle;
    if (started && !life.ended() && clock.now() - *started > from_seconds(config.max_time_s)) {
      life.abort("it took longer than max_time_s");
      stop();
    }
    if (base == planning::BaseState::kStopped && life.state() == MissionState::kRunning) {
      (void)life.command(planning::MissionCommand::kPause, "the emergency stop");
      stop();
    }
    if (life.state() == MissionState::kAligning) align();
    if (life.state() == MissionState::kRunning && arrived()) {
      life.finish();
      stop();
    }
    if (life.state() != reported || cycle % kCyclesPerReport == 0) report();
  }

  [[nodiscard]] bool knows_where() const {
    const bool world = pose && pose->frame == fusion::Frame::kWorld;
    return pose && pose->status == fusion::Status::kOk && (world || config.map_frame == "odom");
  }

  void align() {
    if (base == planning::BaseState::kDisarmed && cycle % kCyclesPerRequest == 0) ask(base_request_t::ACTION_ARM);
    if (base != planning::BaseState::kArmed || !knows_where()) return;
    life.aligned();
    loop = planning::make_loop(to_pose2(pose->T_frame_body), config.loop);
    loop_m = planning::length_m(loop);
    order(loop);
  }

  /// The rest of the path, from where the robot stands.
  void drive_on() {
    if (loop.empty()) return;
    const double driven_m = drive && drive->path_sequence == path_sequence ? loop_m - drive->remaining_m : 0;
    order(planning::rest_of(loop, driven_m, to_pose2(pose->T_frame_body).position_m()));
  }

  [[nodiscard]] bool arrived() const { return drive && drive->arrived && drive->path_sequence == path_sequence; }

  void order(const std::vector<Eigen::Vector2d>& points) {
    publish(bus, channels::kPath,
            planning::to_wire(planning::PathOrder{pose->stamp, ++path_sequence, config.map_frame, points, {}, 0}));
    loop_m = planning::length_m(points);
    loop = points;
  }

  void stop() {
    publish(bus, channels::kPath,
            planning::to_wire(planning::PathOrder{clock.now(), ++path_sequence, config.map_frame, {}, {}, 0}));
    if (life.ended()) ask(base_request_t::ACTION_DISARM);
  }

  void ask(std::int8_t action) { publish(bus, channels::kBaseRequest, planning::request(clock.now(), action, kName)); }

  [[nodiscard]] std::string activity() const {
    switch (life.state()) {
      case MissionState::kAligning:
        return !pose || base != planning::BaseState::kArmed ? "arming the base" : "looking for the tag cube";
      case MissionState::kRunning:
        return drive && drive->braking ? "braking: " + drive->reason : "driving the loop";
      default:
        return planning::describe(life.state());
    }
  }

  void report() {
    planning::MissionReport report;
    report.stamp = clock.now();
    report.state = reported = life.state();
    report.activity = activity();
    report.reason = life.reason();
    if (life.state() == MissionState::kDone) {
      report.progress = 1;
      report.left_s = 0;
    } else if (drive && drive->path_sequence == path_sequence && loop_m > 0) {
      report.progress = 1 - drive->remaining_m / loop_m;
      report.left_s = drive->remaining_m / kNominalSpeedMps;
    }
    publish(bus, channels::kMissionState, planning::to_wire(report));
  }
};

MissionProcess::MissionProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  state_->listen_all();
  clock.every(kCycle, [this] { state_->step(); });
}

MissionProcess::~MissionProcess() = default;

void MissionProcess::finish() {
  if (state_->life.ended() || !state_->started) return;
  state_->life.abort("the process was ended");
  state_->stop();
  state_->report();
}

}  // namespace arpent
