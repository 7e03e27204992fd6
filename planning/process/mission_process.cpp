// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/process/mission_process.h"

#include <algorithm>
#include <arpent/body_pose_t.hpp>
#include <arpent/depth_t.hpp>
#include <cmath>
#include <optional>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/error.h"
#include "common/time_join.h"
#include "perception/fusion/wire.h"
#include "perception/stereo/rectifier.h"
#include "perception/stereo/wire.h"
#include "planning/mission/lifecycle.h"
#include "planning/mission/path_progress.h"
#include "planning/mission/task.h"
#include "planning/viewpoints/certificate_file.h"
#include "planning/viewpoints/level_camera.h"
#include "planning/wire.h"

namespace arpent {
namespace {

constexpr Duration kCycle = std::chrono::milliseconds(100);
constexpr double kBackwardsMps = 0.2;
constexpr int kCyclesPerReport = 10;
constexpr int kCyclesPerRequest = 10;
/// Depth that falls this far behind the newest depth without its pose is passed over.
constexpr Duration kHorizon = std::chrono::seconds(10);

}  // namespace

using planning::MissionState;

/// What kind explore needs beside its task.
struct Eyes {
  Pose T_body_cam;
  planning::LevelCamera camera;
  planning::StopGuard guard;
  TimeJoin<stereo::StampedDepth, fusion::FusedPose> join{kHorizon};
};

struct MissionProcess::State {
  Config config;
  Bus& bus;
  Clock& clock;
  planning::Lifecycle life;
  std::unique_ptr<planning::Task> task;
  std::optional<Eyes> eyes;
  std::optional<TeamMember> member;  ///< in a team
  std::optional<Time> started;
  std::optional<Pose2> begun;  ///< where the robot stood when it knew where it is
  std::optional<fusion::FusedPose> pose;
  std::optional<planning::BaseState> base;
  std::optional<planning::DriveReport> drive;
  std::int64_t path_sequence = 0;
  double left_m = 0;  ///< of the last path, as far as it is known; a stop leaves it
  bool arming = false;
  bool blocked = false;
  std::int64_t cycle = 0;
  MissionState reported = MissionState::kAborted;

  State(const Config& c, Bus& process_bus, Clock& process_clock) : config(c), bus(process_bus), clock(process_clock) {
    if (c.kind == "loop") {
      task = planning::make_loop_task(c.loop);
      return;
    }
    if (c.rig.empty()) throw InputError("mission_process: kind explore needs a rig");
    const Rig rig = load_rig(c.rig);
    const stereo::Rectifier rectifier(rig.calibration);
    const Pose T_body_cam = rectifier.T_body_rectified();
    const planning::LevelCamera camera = planning::make_level_camera(
        rectifier.stereo(), T_body_cam, c.explore.tsdf.min_range_m, c.explore.tsdf.max_range_m);
    eyes.emplace(Eyes{T_body_cam, camera, {c.stop_guard, planning::Footprint(c.explore.footprint)}});
    auto explore = std::make_unique<planning::ExploreTask>(c.explore, camera);
    if (!c.team.robot.empty()) member.emplace(c.team, c.explore.footprint, explore->explorer(), bus, clock);
    task = std::move(explore);
  }

  void refuse(const char* channel, const std::string& fault) const {
    bus.health().count(channel, "invalid");
    bus.health().warn(std::string(channel) + ": message dropped: " + fault);
  }

  template <class Message, class Convert, class Use>
  void listen(const char* channel, const SubscriptionOptions& options, Convert convert, Use use) {
    subscribe<Message>(bus, channel, options, [this, channel, convert, use](const Message& message) {
      if (auto value = convert(message)) {
        use(*value);
      } else {
        refuse(channel, value.fault());
      }
    });
  }

  void listen_all() {
    const SubscriptionOptions few{.queue_capacity = 4};
    listen<mission_command_t>(
        channels::kMissionCommand, few, [](const auto& m) { return planning::from_wire(m); },
        [this](const auto& order) { obey(order); });
    listen<body_pose_t>(
        channels::kPose, few, [](const auto& m) { return fusion::from_wire(m); },
        [this](const auto& value) { pose = value; });
    listen<wheel_state_t>(
        channels::kWheelState, few, [](const auto& m) { return planning::from_wire(m); },
        [this](const auto& value) { base = value; });
    listen<tracker_status_t>(
        channels::kTrackerStatus, few, [](const auto& m) { return planning::from_wire(m); },
        [this](const auto& value) { drive = value; });
    if (!eyes) return;
    listen<depth_t>(
        channels::kDepth, {.queue_capacity = 8, .latency = Duration(config.latency_us)},
        [](const auto& m) { return stereo::from_wire(m); },
        [this](auto& depth) {
          const Time stamp = depth.stamp;
          if (!eyes->join.push_left(stamp, std::move(depth)))
            refuse(channels::kDepth, "its time is not after the last");
          see();
        });
    listen<body_pose_t>(
        channels::kPairPose, {.queue_capacity = 16}, [](const auto& m) { return fusion::from_wire(m); },
        [this](const auto& value) {
          if (!eyes->join.push_right(value.stamp, value)) refuse(channels::kPairPose, "its time is not after the last");
          see();
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
        arming = true;
        break;
      case planning::MissionCommand::kResume:
        arming = true;  // a released emergency stop leaves the base disarmed
        if (life.state() == MissionState::kRunning) task->resume(to_pose2(pose->T_frame_body), drive_state());
        break;
      case planning::MissionCommand::kPause:
      case planning::MissionCommand::kAbort:
        stop();
        break;
    }
    report();
  }

  /// Depth whose pose is known goes into the map; the guard looks at it first.
  void see() {
    for (auto& [stamp, depth, at] : eyes->join.take()) {
      if (!at || at->status == fusion::Status::kLost || !is_in_map_frame(*at)) {
        bus.health().count(channels::kDepth, "rejected");
        continue;
      }
      guard(depth.map, *at);
      if (member) member->mask(stamp, depth.map, at->T_frame_body * eyes->T_body_cam);
      // The end was decided on what was seen until then; the certificate speaks of that.
      if (!life.ended()) task->see(depth.map, at->T_frame_body * eyes->T_body_cam, to_pose2(at->T_frame_body));
      step_task();
    }
  }

  void guard(const stereo::DepthMap& depth, const fusion::FusedPose& at) {
    const planning::StopDecision decision = eyes->guard.look(depth, eyes->T_body_cam, at.twist);
    // Once the robot stands, or backs off, the planner finds the way out: what is ahead is in its map by then.
    const bool stands_or_backs = at.twist.speed_mps < 0.02 && std::abs(at.twist.turn_rate_radps) < 0.05;
    const bool in_the_way = decision.stop && !stands_or_backs;
    if (in_the_way && !blocked && life.state() == MissionState::kRunning) {
      bus.health().count("GUARD", "stops");
      bus.health().warn("stopped: something is in the way");
      stop();
    }
    blocked = in_the_way;
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
    arm();
    if (life.state() == MissionState::kAligning) align();
    if (member) step_member();
    step_task();
    if (life.state() != reported || cycle % kCyclesPerReport == 0) report();
  }

  void step_member() {
    if (!pose || !is_in_map_frame(*pose)) return;
    const double sigma_m = std::sqrt(std::max(pose->covariance(0, 0), pose->covariance(1, 1)));
    const bool must_stop = member->step(life.state(), pose->stamp, to_pose2(pose->T_frame_body), pose->twist, sigma_m);
    if (must_stop && life.state() == MissionState::kRunning) stop();
  }

  [[nodiscard]] bool is_in_map_frame(const fusion::FusedPose& p) const {
    return (p.frame == fusion::Frame::kWorld) == (config.map_frame == "world");
  }

  /// Before the drive and after a pause; a base that disarms itself on the way stays so.
  void arm() {
    if (life.state() != MissionState::kAligning && life.state() != MissionState::kRunning) return;
    if (base == planning::BaseState::kArmed) arming = false;
    if ((arming || life.state() == MissionState::kAligning) && base == planning::BaseState::kDisarmed &&
        cycle % kCyclesPerRequest == 0) {
      ask(base_request_t::ACTION_ARM);
    }
  }

  void align() {
    const bool knows_where = pose && pose->status == fusion::Status::kOk && is_in_map_frame(*pose);
    if (base != planning::BaseState::kArmed || !knows_where) return;
    life.aligned();
    begun = to_pose2(pose->T_frame_body);
    task->begin(*begun);
  }

  /// Of the path that was ordered last.
  [[nodiscard]] planning::DriveState drive_state() const {
    planning::DriveState state{.remaining_m = left_m, .blocked = blocked};
    if (pose) state.speed_mps = pose->twist.speed_mps;
    if (!drive || drive->path_sequence != path_sequence) return state;
    state.arrived = drive->arrived;
    state.remaining_m = drive->remaining_m;
    state.pushes = !drive->arrived && !drive->braking;
    return state;
  }

  void step_task() {
    if (life.state() != MissionState::kRunning || !pose) return;
    const auto request = task->step(clock.now(), to_pose2(pose->T_frame_body), drive_state());
    if (request) order(*request);
    const planning::TaskProgress progress = task->progress(drive_state());
    if (!progress.failure.empty()) {
      life.abort(progress.failure);
    } else if (progress.done) {
      life.finish();
    } else {
      return;
    }
    stop();
    report();
  }

  void order(const planning::PathRequest& request) {
    if (member && request.points_m.empty()) member->note_stop();
    if (member && !request.points_m.empty() && !member->may_drive(to_pose2(pose->T_frame_body), request)) return;
    left_m = request.points_m.empty() ? drive_state().remaining_m : planning::length_m(request.points_m);
    planning::PathOrder path;
    path.stamp = pose ? pose->stamp : clock.now();
    path.sequence = ++path_sequence;
    path.frame = config.map_frame;
    path.points_m = request.points_m;
    path.backwards = request.backwards;
    path.goal_heading_rad = request.goal_heading_rad;
    path.max_speed_mps = request.backwards ? kBackwardsMps : 0;
    publish(bus, channels::kPath, planning::to_wire(path));
  }

  void stop() {
    order({});
    if (life.ended()) ask(base_request_t::ACTION_DISARM);
  }

  void ask(std::int8_t action) { publish(bus, channels::kBaseRequest, planning::request(clock.now(), action, kName)); }

  [[nodiscard]] std::string activity(const planning::TaskProgress& progress) const {
    switch (life.state()) {
      case MissionState::kAligning:
        return !pose || base != planning::BaseState::kArmed ? "arming the base" : "looking for the tag cube";
      case MissionState::kRunning:
        return drive && drive->braking ? "braking: " + drive->reason : progress.activity;
      default:
        return planning::describe(life.state());
    }
  }

  void write_certificate() const {
    const auto* explore = dynamic_cast<const planning::ExploreTask*>(task.get());
    if (explore == nullptr || config.certificate_file.empty() || !begun || !pose) return;
    planning::CertificateContext context;
    context.end = life.state() == MissionState::kDone ? "done" : "aborted";
    context.reason = life.reason();
    context.map_frame = config.map_frame;
    context.voxel_m = config.explore.tsdf.voxel_m;
    context.known_weight = config.explore.tsdf.known_weight;
    const planning::ViewpointParams& viewpoints = config.explore.viewpoints;
    context.give_up_factor = std::min(viewpoints.give_up_factor, viewpoints.blank_factor);
    context.least_piece_m = viewpoints.least_piece_m;
    context.start = *begun;
    context.semi_long_m = config.explore.footprint.semi_axis_long_m;
    context.semi_short_m = config.explore.footprint.semi_axis_short_m;
    context.camera = eyes->camera;
    context.lattice_m = viewpoints.lattice_m;
    auto certification = explore->explorer().certify(to_pose2(pose->T_frame_body));
    context.poses = std::move(certification.poses);
    planning::write_certificates(config.certificate_file, context, certification.certificates);
  }

  void report() {
    const planning::TaskProgress progress = task->progress(drive_state());
    planning::MissionReport report;
    report.stamp = clock.now();
    report.state = reported = life.state();
    report.activity = activity(progress);
    report.reason = life.reason();
    report.progress = progress.share;
    report.left_s = progress.left_s;
    publish(bus, channels::kMissionState, planning::to_wire(report));
  }
};

MissionProcess::MissionProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  state_->listen_all();
  clock.every(kCycle, [this] { state_->step(); });
}

MissionProcess::~MissionProcess() = default;

const planning::Explorer* MissionProcess::explorer() const {
  const auto* task = dynamic_cast<const planning::ExploreTask*>(state_->task.get());
  return task == nullptr ? nullptr : &task->explorer();
}

void MissionProcess::finish() {
  if (!state_->started) return;
  if (!state_->life.ended()) {
    state_->life.abort("the process was ended");
    state_->stop();
    state_->report();
  }
  state_->write_certificate();
}

}  // namespace arpent
