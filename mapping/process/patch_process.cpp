// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/process/patch_process.h"

#include <algorithm>
#include <arpent/tour_t.hpp>
#include <cmath>
#include <deque>
#include <utility>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/time_join.h"
#include "mapping/wire.h"
#include "perception/fusion/wire.h"
#include "perception/stereo/rectifier.h"
#include "perception/stereo/wire.h"

namespace arpent {
namespace {

/// Depth that falls this far behind the newest depth without its pose is passed over.
constexpr Duration kHorizon = std::chrono::seconds(10);
/// With each tour: some 40 kB/s.
constexpr int kMostSentAgain = 10;
constexpr std::size_t kMostKept = 10000;  ///< samples, of 8 kB at most

}  // namespace

struct PatchProcess::State {
  /// A sample of which it is not known that the centre has it.
  struct Sent {
    map_patch_t message;
    Time at;  ///< the last time
  };

  Config config;
  Bus& bus;
  Clock& clock;
  Pose T_body_cam;
  mapping::PatchBuilder builder;
  mapping::TeammatePoses teammates;
  std::deque<Sent> sent;
  TimeJoin<stereo::StampedDepth, fusion::FusedPose> join{kHorizon};

  State(const Config& c, Bus& process_bus, Clock& process_clock)
      : config(c),
        bus(process_bus),
        clock(process_clock),
        T_body_cam(stereo::Rectifier(load_rig(c.rig).calibration).T_body_rectified()),
        builder(c.patch, c.tsdf, c.source, c.map_frame) {}

  void refuse(const char* channel, const std::string& fault) const {
    bus.health().count(channel, "invalid");
    bus.health().warn(std::string(channel) + ": message dropped: " + fault);
  }

  void take_depth(const depth_t& message) {
    auto depth = stereo::from_wire(message);
    if (!depth) return refuse(channels::kDepth, depth.fault());
    const Time stamp = depth->stamp;
    if (!join.push_left(stamp, std::move(*depth))) return refuse(channels::kDepth, "its time is not after the last");
    integrate_ready();
  }

  void take_pose(const body_pose_t& message) {
    const auto pose = fusion::from_wire(message);
    if (!pose) return refuse(channels::kPairPose, pose.fault());
    if (!join.push_right(pose->stamp, *pose)) return refuse(channels::kPairPose, "its time is not after the last");
    integrate_ready();
  }

  void take_teammate(const robot_state_t& message) {
    const auto state = mapping::from_wire(message);
    if (!state) return refuse(channels::kTeamState, state.fault());
    teammates.note(*state);
  }

  void integrate_ready() {
    for (auto& [stamp, depth, at] : join.take()) {
      const bool placed = at && at->status != fusion::Status::kLost &&
                          (at->frame == fusion::Frame::kWorld) == (config.map_frame == "world");
      if (!placed) {
        bus.health().count(channels::kDepth, "rejected");
        continue;
      }
      integrate(stamp, depth.map, *at);
    }
  }

  void integrate(Time stamp, stereo::DepthMap& depth, const fusion::FusedPose& at) {
    const Pose T_map_cam = at.T_frame_body * T_body_cam;
    const auto seen = teammates.at(stamp);
    bus.health().count("MASK", "pixels", mapping::mask_teammates(depth, T_map_cam, seen, config.mask));
    const double position_sigma_m = std::sqrt(std::max(at.covariance(0, 0), at.covariance(1, 1)));
    const mapping::PosedDepth image{
        stamp, depth, T_map_cam, to_pose2(at.T_frame_body), position_sigma_m, std::sqrt(at.covariance(5, 5))};
    for (const mapping::MapPatch& patch : builder.add(image)) send(to_wire(patch));
  }

  void send(map_patch_t message) {
    publish(bus, channels::kMapPatch, message);
    sent.push_back({std::move(message), clock.now()});
    if (sent.size() > kMostKept) sent.pop_front();
  }

  /// The centre says in its tours what it has.
  void take_tour(const tour_t& message) {
    if (message.robot != config.source) return;
    while (!sent.empty() && sent.front().message.sample < message.samples_below) sent.pop_front();
    int again = 0;
    for (Sent& patch : sent) {
      if (clock.now() - patch.at < from_seconds(config.send_again_s)) continue;
      if (++again > kMostSentAgain) return;
      publish(bus, channels::kMapPatch, patch.message);
      patch.at = clock.now();
      bus.health().count(channels::kMapPatch, "sent_again");
    }
  }
};

PatchProcess::PatchProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  const SubscriptionOptions depth{.queue_capacity = 32, .latency = Duration(config.latency_us)};
  subscribe<depth_t>(bus, channels::kDepth, depth, [this](const depth_t& m) { state_->take_depth(m); });
  subscribe<body_pose_t>(bus, channels::kPairPose, {.queue_capacity = 128},
                         [this](const body_pose_t& m) { state_->take_pose(m); });
  subscribe<robot_state_t>(bus, channels::kTeamState, {.queue_capacity = 64},
                           [this](const robot_state_t& m) { state_->take_teammate(m); });
  subscribe<tour_t>(bus, channels::kTeamTour, {.queue_capacity = 16},
                    [this](const tour_t& m) { state_->take_tour(m); });
}

PatchProcess::~PatchProcess() = default;

}  // namespace arpent
