// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/process/odometry_process.h"

#include <arpent/imu_t.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "perception/odometry/wire.h"
#include "perception/stereo/rectifier.h"
#include "perception/stereo/wire.h"

namespace arpent {
namespace {

constexpr double kMaxDisparityOffsetPx = 0.3;
/// A rate that no robot turns at.
constexpr double kMaxRateRadps = 50;
constexpr std::size_t kMaxGyro = 4096;
constexpr Duration kGyroMargin = std::chrono::milliseconds(40);
constexpr Duration kGyroSilent = std::chrono::milliseconds(120);

}  // namespace

struct OdometryProcess::State {
  Bus& bus;
  stereo::Rectifier rectifier;
  stereo::FrozenWatch watch;
  Pose T_body_cam;
  odometry::StereoOdometry odometry;
  std::optional<odometry::BodyOdometry> last;
  std::map<Time, double> gyro;  ///< rate about body z [rad/s], since the last pair
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

  void note_gyro(const imu_t& message) {
    const double rate_radps = message.angular_velocity_radps[2];
    if (std::abs(rate_radps) > kMaxRateRadps) {
      bus.health().count(channels::kImu, "invalid");
      return;
    }
    gyro[from_utime(message.utime)] = rate_radps;
    while (gyro.size() > kMaxGyro) gyro.erase(gyro.begin());
  }

  /// How the camera has turned since the last pair; its bias matters little for where points are looked for. Only
  /// readings that have surely come by now count, so that live and lockstep agree; the newest of them goes on until the
  /// pair's time. Nullopt if the gyro is silent.
  std::optional<Eigen::Matrix3d> turn_until(Time stamp) {
    const std::optional<Time> from = std::exchange(last_pair, stamp);
    const auto end = gyro.upper_bound(stamp - kGyroMargin);
    if (!from || end == gyro.begin() || stamp - std::prev(end)->first > kGyroSilent) return std::nullopt;
    double turn_rad = 0;
    Time now = *from;
    for (auto it = gyro.begin(); it != end; ++it) {
      if (it->first <= now) continue;
      turn_rad += it->second * to_seconds(it->first - now);
      now = it->first;
    }
    turn_rad += std::prev(end)->second * to_seconds(stamp - now);
    gyro.erase(gyro.begin(), std::prev(end));
    const Eigen::Matrix3d R_body = Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return T_body_cam.linear().transpose() * R_body * T_body_cam.linear();
  }

  /// Beyond doubt: by more than three deviations.
  [[nodiscard]] bool disparities_are_off() const {
    const odometry::DisparityOffset offset = odometry.disparity_offset();
    return std::abs(offset.px) - 3 * std::sqrt(offset.variance_px2) > kMaxDisparityOffsetPx;
  }

  odometry::BodyOdometry estimate(const stereo::StereoPair& pair) {
    const auto [left, right] = rectifier.rectify(pair.left, pair.right);
    return to_body(odometry.track(pair.stamp, left, right, turn_until(pair.stamp)), pair.sequence, T_body_cam,
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
  subscribe<imu_t>(bus, channels::kImu, options, [this](const imu_t& message) { state_->note_gyro(message); });
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
