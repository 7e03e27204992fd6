// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/process/depth_process.h"

#include <cmath>
#include <optional>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "perception/stereo/depth.h"
#include "perception/stereo/rectifier.h"
#include "perception/stereo/wire.h"

namespace arpent {
namespace {

constexpr double kMaxVerticalOffsetPx = 0.5;
/// A pair counts as due this share of a period early, so that a 10 Hz camera gives an even 5 Hz in spite of its jitter.
constexpr double kEarlyShare = 0.25;

}  // namespace

struct DepthProcess::State {
  Config config;
  Bus& bus;
  stereo::Rectifier rectifier;
  stereo::FrozenWatch watch;
  std::unique_ptr<stereo::StereoMatcher> matcher;
  std::optional<Time> last;

  State(const Config& process_config, Bus& process_bus)
      : config(process_config),
        bus(process_bus),
        rectifier(load_rig(config.rig).calibration),
        matcher(stereo::make_matcher(config.matcher)) {}

  /// The utime rule: pairs closer than a period to the last one used are passed over.
  bool due(Time stamp) {
    const Duration period = from_seconds((1.0 - kEarlyShare) / config.rate_hz);
    if (last && stamp > *last && stamp - *last < period) return false;
    last = stamp;
    return true;
  }

  void publish_all(const stereo::StereoPair& pair, const stereo::Disparities& disparities) const {
    using stereo::DisparityKind;
    const auto send_disparity = [&](const char* channel, DisparityKind kind, const cv::Mat1w& px128) {
      publish(bus, channel,
              to_wire(pair.stamp, pair.sequence, kind, rectifier.stereo(), disparities.vertical_offset_px, px128));
    };
    if (config.publish_disparity) send_disparity(channels::kDisparity, DisparityKind::kTrusted, disparities.trusted);
    if (config.publish_filled) send_disparity(channels::kDisparityFilled, DisparityKind::kFilled, disparities.filled);
    const stereo::DepthMap depth = stereo::depth_from_disparity(
        disparities.trusted, disparities.sigma_px, rectifier.stereo(), config.min_range_m, config.max_range_m);
    publish(bus, channels::kDepth, to_wire(stereo::StampedDepth{pair.stamp, pair.sequence, depth}));
  }

  void warn_of_misalignment(double vertical_offset_px) const {
    if (!(std::abs(vertical_offset_px) > kMaxVerticalOffsetPx)) return;
    bus.health().count(channels::kStereoImages, "misaligned");
    bus.health().warn("the images are vertically misaligned by more than 0.5 px: calibrate the rig again");
  }
};

DepthProcess::DepthProcess(const Config& config, Bus& bus, Clock& /*clock*/)
    : state_(std::make_unique<State>(config, bus)) {
  SubscriptionOptions options;
  options.queue_capacity = 16;
  options.latency = Duration(config.latency_us);
  subscribe<stereo_images_t>(bus, channels::kStereoImages, options,
                             [this](const stereo_images_t& message) { on_pair(message); });
}

DepthProcess::~DepthProcess() = default;

void DepthProcess::on_pair(const stereo_images_t& message) {
  if (!state_->due(from_utime(message.utime))) return;
  const auto pair = stereo::from_wire(message);
  std::string fault = pair ? stereo::find_fault(*pair, state_->rectifier.stereo().camera) : pair.fault();
  if (const std::string frozen = state_->watch.find_fault(message); fault.empty()) fault = frozen;
  if (!fault.empty()) {
    state_->bus.health().count(channels::kStereoImages, "invalid");
    state_->bus.health().warn("pair not used: " + fault);
    return;
  }
  const auto [left, right] = state_->rectifier.rectify(pair->left, pair->right);
  const stereo::Disparities disparities = state_->matcher->match(left, right);
  state_->warn_of_misalignment(disparities.vertical_offset_px);
  state_->publish_all(*pair, disparities);
}

}  // namespace arpent
