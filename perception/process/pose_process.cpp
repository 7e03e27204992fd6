// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/process/pose_process.h"

#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <variant>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "perception/fusion/wire.h"

namespace arpent {
namespace {

/// A gyro, or wheels, that are this far behind the others are silent.
constexpr Duration kSilent = std::chrono::milliseconds(500);
constexpr int kFewRepeats = 2;

using Reading =
    std::variant<fusion::GyroReading, fusion::OdometryReading, fusion::WorldReading, fusion::AlignmentReading>;

/// A reading that has come and does not count yet.
struct HeldReading {
  const char* channel;
  Reading reading;
  std::int64_t sequence;
};

}  // namespace

struct PoseProcess::State {
  Config config;
  Bus& bus;
  fusion::PoseFusion fusion;
  fusion::ContinuousPose continuous;
  std::deque<Time> waiting;                                       ///< wheel states whose POSE is due
  std::multimap<std::pair<Time, std::size_t>, HeldReading> held;  ///< by when they count, then by kind
  std::optional<Time> counted;                                    ///< everything of up to then is in the estimate
  std::optional<Time> newest_gyro, newest_wheels;
  int repeats = 0;          ///< of the newest wheels
  Duration gyro_period{0};  ///< between its newest two readings
  std::int64_t sequence = 0;
  fusion::FilterState reported;  ///< counts that health knows

  State(const Config& process_config, Bus& process_bus)
      : config(process_config), bus(process_bus), fusion(config.fusion), continuous(config.blend) {}

  void refuse(const char* channel, const std::string& fault) const {
    bus.health().count(channel, "invalid");
    bus.health().warn(std::string(channel) + ": message dropped: " + fault);
  }

  /// Holds a reading until the wheels are at its time and `camera_wait_s` beyond, if a camera made it.
  template <class Message>
  void hold(const char* channel, const Message& message, Duration wait, std::int64_t number = 0) {
    const auto reading = fusion::from_wire(message);
    if (!reading) return refuse(channel, reading.fault());
    const Time counts = reading->stamp + wait;
    const bool late = counted && counts <= *counted;
    const bool alone = !newest_wheels || reading->stamp - *newest_wheels > kSilent;
    const Reading value = *reading;
    held.emplace(std::pair(counts, value.index()), HeldReading{channel, value, number});
    if (late) bus.health().count(channel, "late");
    if (late || (alone && wait > Duration(0))) count_until(counts);
  }

  /// Takes what counts at `until` into the estimate, in the order in which it counts.
  void count_until(Time until) {
    while (!held.empty() && held.begin()->first.first <= until) {
      const HeldReading next = std::move(held.extract(held.begin()).mapped());
      const std::string fault = std::visit([&](const auto& reading) { return fusion.add(reading); }, next.reading);
      if (!fault.empty()) {
        refuse(next.channel, fault);
      } else if (const auto* odometry = std::get_if<fusion::OdometryReading>(&next.reading)) {
        publish_pair_pose(odometry->stamp, next.sequence);
      }
    }
  }

  [[nodiscard]] bool decided(Time stamp) const {
    if (!newest_gyro || *newest_gyro >= stamp || stamp - *newest_gyro > kSilent) return true;
    if (*newest_gyro + gyro_period > stamp) return true;  // the next reading will be of later
    return *newest_wheels - stamp >= from_seconds(config.gyro_wait_s);
  }

  void publish_ready() {
    while (!waiting.empty() && decided(waiting.front())) {
      counted = waiting.front();
      count_until(*counted);
      publish_pose(*counted);
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

  void publish_pair_pose(Time stamp, std::int64_t number) {
    const auto pose = fusion.at(stamp);
    if (pose) publish(bus, channels::kPairPose, fusion::to_wire(*pose, number));
    if (pose && pose->status != fusion::Status::kOk) bus.health().warn("pose: " + pose->reason);
    report();
  }

  void on_wheels(const wheel_state_t& message) {
    if (message.utime == 0) return bus.health().count(channels::kWheelState, "silent");  // nothing measured yet
    if (newest_wheels == from_utime(message.utime)) return on_unheard();
    const auto reading = fusion::from_wire(message);
    if (!reading) return refuse(channels::kWheelState, reading.fault());
    if (const std::string fault = fusion.add(*reading); !fault.empty()) return refuse(channels::kWheelState, fault);
    newest_wheels = reading->stamp;
    repeats = 0;
    waiting.push_back(reading->stamp);
    publish_ready();
  }

  /// The base repeats its last reading. Once or twice: its next came a moment too late for the driver's cycle. More
  /// often: it is not heard, and the other inputs say how late it is.
  void on_unheard() {
    bus.health().count(channels::kWheelState, "repeated");
    if (++repeats <= kFewRepeats || !waiting.empty()) return;
    if (newest_gyro) counted = std::max(*newest_gyro, *newest_wheels);
    if (counted) count_until(*counted);
    const std::optional<Time> last = continuous.last_stamp();
    if (!last || *fusion.newest() > *last) publish_pose(*fusion.newest());
  }

  void on_imu(const imu_t& message) {
    hold(channels::kImu, message, Duration(0));
    const Time stamp = from_utime(message.utime);
    if (newest_gyro) gyro_period = stamp - *newest_gyro;
    newest_gyro = stamp;
    publish_ready();
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
  const Duration wait = from_seconds(config.camera_wait_s);
  SubscriptionOptions options;
  options.latency = Duration(config.latency_us);
  options.queue_capacity = 64;
  subscribe<wheel_state_t>(bus, channels::kWheelState, options,
                           [&state](const wheel_state_t& message) { state.on_wheels(message); });
  subscribe<odometry_t>(bus, channels::kOdometry, options, [&state, wait](const odometry_t& message) {
    state.hold(channels::kOdometry, message, wait, message.sequence);
  });
  subscribe<tag_observation_t>(bus, channels::kTagObservation, options,
                               [&state, wait](const tag_observation_t& message) {
                                 if (message.accepted != 0) state.hold(channels::kTagObservation, message, wait);
                               });
  subscribe<frame_alignment_t>(
      bus, channels::kFrameAlignment, options,
      [&state, wait](const frame_alignment_t& message) { state.hold(channels::kFrameAlignment, message, wait); });
  options.queue_capacity = 256;
  if (config.fusion.gyro.used) {
    subscribe<imu_t>(bus, channels::kImu, options, [&state](const imu_t& message) { state.on_imu(message); });
  }
}

PoseProcess::~PoseProcess() = default;

}  // namespace arpent
