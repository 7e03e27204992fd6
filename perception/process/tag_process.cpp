// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/process/tag_process.h"

#include <optional>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/time_join.h"
#include "perception/odometry/wire.h"
#include "perception/stereo/rectifier.h"
#include "perception/stereo/wire.h"
#include "perception/tags/observer.h"
#include "perception/tags/wire.h"

namespace arpent {
namespace {

/// A view that falls this far behind the newest view without its odometry is passed over.
constexpr Duration kHorizon = std::chrono::seconds(10);
/// A pair counts as due this share of a period early, so that a camera's jitter does not halve the rate.
constexpr double kEarlyShare = 0.25;

}  // namespace

struct TagProcess::State {
  Config config;
  Bus& bus;
  stereo::Rectifier rectifier;
  tags::TagObserver observer;
  tags::FrameAligner aligner;
  TimeJoin<tags::CubePose, odometry::BodyOdometry> join{kHorizon};
  std::optional<Time> last;

  State(const Config& process_config, Bus& process_bus)
      : config(process_config),
        bus(process_bus),
        rectifier(load_rig(config.rig).calibration),
        observer(config.cube, config.detector, config.ground, rectifier.stereo(), rectifier.T_body_rectified()),
        aligner(config.alignment, config.ground) {}

  /// The utime rule: pairs closer than a period to the last one used are passed over.
  bool due(Time stamp) {
    const double rate_hz = aligner.is_final() ? config.aligned_rate_hz : config.rate_hz;
    if (last && stamp > *last && stamp - *last < from_seconds((1.0 - kEarlyShare) / rate_hz)) return false;
    last = stamp;
    return true;
  }

  void refuse(const char* channel, const std::string& fault) const {
    bus.health().count(channel, "invalid");
    bus.health().warn(std::string(channel) + ": not used: " + fault);
  }

  void align(Time stamp, const tags::CubePose& measured, const odometry::BodyOdometry& odometry) {
    const std::int64_t before = aligner.disagreeing();
    const auto alignment = aligner.add(
        tags::make_view(stamp, measured.T_world_body, measured.covariance, odometry.T_odom_body, odometry.covariance));
    if (aligner.disagreeing() > before) bus.health().count(channels::kTagObservation, "disagreeing");
    if (!alignment) return;
    if (alignment->ground_chi2 > tags::kGroundGate) {
      bus.health().warn("the tags say that odom does not stand on the ground: check the cube, the rig's mounting");
    }
    publish(bus, channels::kFrameAlignment, tags::to_wire(*alignment));
  }
};

TagProcess::TagProcess(const Config& config, Bus& bus, Clock& /*clock*/)
    : state_(std::make_unique<State>(config, bus)) {
  SubscriptionOptions options;
  options.queue_capacity = 16;
  options.latency = Duration(config.latency_us);
  subscribe<stereo_images_t>(bus, channels::kStereoImages, options,
                             [this](const stereo_images_t& message) { on_pair(message); });
  options.latency = Duration(0);
  options.queue_capacity = 128;
  subscribe<odometry_t>(bus, channels::kOdometry, options, [this](const odometry_t& message) { on_odometry(message); });
}

TagProcess::~TagProcess() = default;

void TagProcess::on_pair(const stereo_images_t& message) {
  if (!state_->due(from_utime(message.utime))) return;
  const auto pair = stereo::from_wire(message);
  const std::string fault = pair ? stereo::find_fault(*pair, state_->rectifier.stereo().camera) : pair.fault();
  if (!fault.empty()) return state_->refuse(channels::kStereoImages, fault);
  const auto [left, right] = state_->rectifier.rectify(pair->left, pair->right);
  const tags::Observation observation = state_->observer.observe(left, right);
  if (observation.tags.empty()) return;
  if (!observation.accepted()) state_->bus.health().count(channels::kTagObservation, "rejected");
  publish(state_->bus, channels::kTagObservation,
          tags::to_wire(tags::to_body(pair->stamp, pair->sequence, observation)));
  if (!observation.accepted()) return;
  if (!state_->join.push_left(pair->stamp, observation.measured)) {
    return state_->refuse(channels::kStereoImages, "its time is not after the last one's");
  }
  align_ready();
}

void TagProcess::on_odometry(const odometry_t& message) {
  const auto odometry = odometry::from_wire(message);
  if (!odometry) return state_->refuse(channels::kOdometry, odometry.fault());
  if (!state_->join.push_right(odometry->stamp, *odometry)) {
    return state_->refuse(channels::kOdometry, "its time is not after the last one's");
  }
  align_ready();
  if (odometry->status == odometry::Status::kLost) state_->aligner.forget(odometry->stamp);
}

void TagProcess::align_ready() {
  for (const auto& [stamp, measured, odometry] : state_->join.take()) {
    if (odometry && odometry->status != odometry::Status::kLost) {
      state_->align(stamp, measured, *odometry);
    } else {
      state_->bus.health().count(channels::kTagObservation, "without odometry");
    }
  }
}

}  // namespace arpent
