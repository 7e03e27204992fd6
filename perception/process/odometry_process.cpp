// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/process/odometry_process.h"

#include <cmath>
#include <optional>
#include <utility>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "perception/fusion/wire.h"
#include "perception/odometry/motion_hint.h"
#include "perception/odometry/wire.h"
#include "perception/stereo/rectifier.h"
#include "perception/stereo/wire.h"

namespace arpent {
namespace {

constexpr double kMaxDisparityOffsetPx = 0.3;

}  // namespace

struct OdometryProcess::State {
  Bus& bus;
  stereo::Rectifier rectifier;
  stereo::FrozenWatch watch;
  Pose T_body_cam;
  odometry::StereoOdometry odometry;
  std::optional<odometry::BodyOdometry> last;
  odometry::MotionHint hint;
  std::optional<Time> last_pair;

  State(const Config& config, Bus& process_bus)
      : bus(process_bus),
        rectifier(load_rig(config.rig).calibration),
        T_body_cam(rectifier.T_body_rectified()),
        odometry(rectifier.stereo(), config.odometry) {}

  /// The answer for a pair that cannot be used: where we were, LOST, and why.
  odometry::BodyOdometry lost(Time stamp, std::int64_t sequence, const std::string& reason) const {
    odometry::BodyOdometry repeated = last.value_or(odometry::BodyOdometry{});
    repeated.stamp = stamp;
    repeated.sequence = sequence;
    repeated.status = odometry::Status::kLost;
    repeated.reason = reason;
    repeated.velocity_body.setZero();
    repeated.tracked = 0;
    repeated.inliers = 0;
    repeated.keyframe = false;
    return repeated;
  }

  void on_imu(const imu_t& message) {
    const auto reading = fusion::from_wire(message);
    if (!reading) return bus.health().count(channels::kImu, "invalid");
    hint.add_turn_rate(reading->stamp, reading->yaw_rate_radps);
  }

  void on_wheels(const wheel_state_t& message) {
    const auto reading = fusion::from_wire(message);
    if (!reading) return bus.health().count(channels::kWheelState, "invalid");
    if (reading->usable) hint.add_way(reading->stamp, 0.5 * (reading->left_m + reading->right_m));
  }

  /// The camera's step since the last pair, as wheels and gyro have it.
  std::optional<Pose> expected_step(Time stamp) {
    const std::optional<Time> from = std::exchange(last_pair, stamp);
    if (!from || stamp <= *from) return std::nullopt;
    const auto step = hint.step(*from, stamp, last ? last->velocity_body.x() : 0);
    if (!step) return std::nullopt;
    return T_body_cam.inverse() * *step * T_body_cam;
  }

  /// Beyond doubt: by more than three deviations.
  [[nodiscard]] bool disparities_are_off() const {
    const odometry::DisparityOffset offset = odometry.disparity_offset();
    return std::abs(offset.px) - 3 * std::sqrt(offset.variance_px2) > kMaxDisparityOffsetPx;
  }

  odometry::BodyOdometry estimate(const stereo::StereoPair& pair) {
    const auto [left, right] = rectifier.rectify(pair.left, pair.right);
    return to_body(odometry.track(pair.stamp, left, right, expected_step(pair.stamp)), pair.sequence, T_body_cam,
                   last ? &*last : nullptr);
  }
};

OdometryProcess::OdometryProcess(const Config& config, Bus& bus, Clock& /*clock*/)
    : state_(std::make_unique<State>(config, bus)) {
  SubscriptionOptions options;
  options.queue_capacity = 16;
  options.latency = Duration(config.latency_us);
  subscribe<stereo_images_t>(bus, channels::kStereoImages, options,
                             [this](const stereo_images_t& message) { on_pair(message); });
  if (!config.use_gyro) return;
  options.queue_capacity = 256;
  options.latency = Duration(0);
  subscribe<imu_t>(bus, channels::kImu, options, [this](const imu_t& message) { state_->on_imu(message); });
  subscribe<wheel_state_t>(bus, channels::kWheelState, options,
                           [this](const wheel_state_t& message) { state_->on_wheels(message); });
}

OdometryProcess::~OdometryProcess() = default;

void OdometryProcess::on_pair(const stereo_images_t& message) {
  const auto pair = stereo::from_wire(message);
  std::string fault = pair ? stereo::find_fault(*pair, state_->rectifier.stereo().camera) : pair.fault();
  if (const std::string frozen = state_->watch.find_fault(message); fault.empty()) fault = frozen;
  if (!fault.empty()) {
    state_->bus.health().count(channels::kStereoImages, "invalid");
    state_->bus.health().warn("pair not used: " + fault);
  }
  state_->last =
      fault.empty() ? state_->estimate(*pair) : state_->lost(from_utime(message.utime), message.sequence, fault);
  if (state_->disparities_are_off()) {
    state_->bus.health().warn("disparities are off by more than 0.3 px everywhere: calibrate the rig again");
  }
  if (state_->last->status != odometry::Status::kOk) state_->bus.health().warn("odometry: " + state_->last->reason);
  publish(state_->bus, channels::kOdometry, to_wire(*state_->last));
}

}  // namespace arpent
