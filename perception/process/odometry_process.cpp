// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/process/odometry_process.h"

#include <cmath>
#include <optional>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
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

  /// Beyond doubt: by more than three deviations.
  [[nodiscard]] bool disparities_are_off() const {
    const odometry::DisparityOffset offset = odometry.disparity_offset();
    return std::abs(offset.px) - 3 * std::sqrt(offset.variance_px2) > kMaxDisparityOffsetPx;
  }

  odometry::BodyOdometry estimate(const stereo::StereoPair& pair) {
    const auto [left, right] = rectifier.rectify(pair.left, pair.right);
    return to_body(odometry.track(pair.stamp, left, right), pair.sequence, T_body_cam, last ? &*last : nullptr);
  }
};

OdometryProcess::OdometryProcess(const Config& config, Bus& bus, Clock& /*clock*/)
    : state_(std::make_unique<State>(config, bus)) {
  SubscriptionOptions options;
  options.queue_capacity = 16;
  options.latency = Duration(config.latency_us);
  subscribe<stereo_images_t>(bus, channels::kStereoImages, options,
                             [this](const stereo_images_t& message) { on_pair(message); });
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
