// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/process/pose_process.h"

#include <deque>
#include <optional>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "perception/fusion/wire.h"

namespace arpent {
namespace {

/// A gyro that is this far behind the wheels is silent.
constexpr Duration kGyroSilent = std::chrono::milliseconds(500);

}  // namespace

struct PoseProcess::State {
  Config config;
  Bus& bus;
  fusion::PoseFusion fusion;
  fusion::ContinuousPose continuous;
  std::deque<Time> waiting;  ///< wheel states whose POSE is due
  std::optional<Time> newest_gyro, newest_wheels;
  Duration gyro_period{0};  ///< between its newest two readings
  std::int64_t sequence = 0;
  fusion::FilterState reported;  ///< counts that health knows

  State(const Config& process_config, Bus& process_bus)
      : config(process_config), bus(process_bus), fusion(config.fusion), continuous(config.blend) {}

  void refuse(const char* channel, const std::string& fault) const {
    bus.health().count(channel, "invalid");
    bus.health().warn(std::string(channel) + ": message dropped: " + fault);
  }

  /// Converts and adds; false if the message is dropped.
  template <class Message>
  bool take(const char* channel, const Message& message) {
    const auto reading = fusion::from_wire(message);
    const std::string fault = reading ? fusion.add(*reading) : reading.fault();
    if (!fault.empty()) refuse(channel, fault);
    return fault.empty();
  }

  [[nodiscard]] bool decided(Time stamp) const {
    if (!newest_gyro || *newest_gyro >= stamp || stamp - *newest_gyro > kGyroSilent) return true;
    if (*newest_gyro + gyro_period > stamp) return true;  // the next reading will be of later
    return *newest_wheels - stamp >= from_seconds(config.gyro_wait_s);
  }

  void publish_ready() {
    while (!waiting.empty() && decided(waiting.front())) {
      publish_pose(waiting.front());
      waiting.pop_front();
    }
  }

  void publish_pose(Time stamp) {
    const std::optional<Time> last = continuous.last_stamp();
    const auto best = fusion.at(stamp);
    if (!best) return bus.health().count(channels::kPose, "skipped");
    const auto best_of_last = last ? fusion.at(*last) : std::nullopt;
    publish(bus, channels::kPose, fusion::to_wire(continuous.next(*best, best_of_last), sequence++));
  }

  void on_wheels(const wheel_state_t& message) {
    if (message.utime == 0) return bus.health().count(channels::kWheelState, "silent");  // nothing measured yet
    const Time stamp = from_utime(message.utime);
    if (newest_wheels == stamp) return on_unheard();
    if (!take(channels::kWheelState, message)) return;
    newest_wheels = stamp;
    waiting.push_back(stamp);
    publish_ready();
  }

  /// The base repeats its last reading: the other inputs say how late it is.
  void on_unheard() {
    bus.health().count(channels::kWheelState, "repeated");
    const std::optional<Time> last = continuous.last_stamp();
    if (waiting.empty() && (!last || *fusion.newest() > *last)) publish_pose(*fusion.newest());
  }

  void on_imu(const imu_t& message) {
    if (!take(channels::kImu, message)) return;
    const Time stamp = from_utime(message.utime);
    if (newest_gyro) gyro_period = stamp - *newest_gyro;
    newest_gyro = stamp;
    publish_ready();
  }

  void on_odometry(const odometry_t& message) {
    if (!take(channels::kOdometry, message)) return;
    const auto pose = fusion.at(from_utime(message.utime));
    if (pose) publish(bus, channels::kPairPose, fusion::to_wire(*pose, message.sequence));
    if (pose && pose->status != fusion::Status::kOk) bus.health().warn("pose: " + pose->reason);
    report();
  }

  /// Counts what the filter decided. Decisions on what came late may change; counts only grow.
  void report() {
    const auto now = fusion.newest_state();
    if (!now) return;
    const auto grow = [&](std::int64_t& known, std::int64_t count, const char* channel, const char* what,
                          const char* warning) {
      if (count <= known) return;
      bus.health().count(channel, what, count - known);
      if (warning != nullptr) bus.health().warn(warning);
      known = count;
    };
    grow(reported.slips, now->slips, channels::kWheelState, "slips", "wheels slip or are at fault");
    grow(reported.refused_odometry, now->refused_odometry, channels::kOdometry, "refused", nullptr);
    grow(reported.used_tags, now->used_tags, channels::kTagObservation, "used", nullptr);
    grow(reported.refused_tags, now->refused_tags, channels::kTagObservation, "refused", "a tag contradicts the pose");
    grow(reported.refused_alignments, now->refused_alignments, channels::kFrameAlignment, "refused",
         "an alignment contradicts the pose");
  }
};

PoseProcess::PoseProcess(const Config& config, Bus& bus, Clock& /*clock*/)
    : state_(std::make_unique<State>(config, bus)) {
  State& state = *state_;
  SubscriptionOptions options;
  options.latency = Duration(config.latency_us);
  options.queue_capacity = 64;
  subscribe<wheel_state_t>(bus, channels::kWheelState, options,
                           [&state](const wheel_state_t& message) { state.on_wheels(message); });
  subscribe<odometry_t>(bus, channels::kOdometry, options,
                        [&state](const odometry_t& message) { state.on_odometry(message); });
  subscribe<tag_observation_t>(bus, channels::kTagObservation, options, [&state](const tag_observation_t& message) {
    if (message.accepted != 0) (void)state.take(channels::kTagObservation, message);
  });
  subscribe<frame_alignment_t>(bus, channels::kFrameAlignment, options, [&state](const frame_alignment_t& message) {
    (void)state.take(channels::kFrameAlignment, message);
  });
  options.queue_capacity = 256;
  if (config.fusion.gyro.used) {
    subscribe<imu_t>(bus, channels::kImu, options, [&state](const imu_t& message) { state.on_imu(message); });
  }
}

PoseProcess::~PoseProcess() = default;

}  // namespace arpent
