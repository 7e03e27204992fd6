// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// patch_process on the in-memory bus: five depth images with their poses become one patch; without a pose in the right
// frame, none; a teammate in view is left out; garbage is counted.
#include "mapping/process/patch_process.h"

#include <gtest/gtest.h>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "mapping/wire.h"
#include "perception/fusion/wire.h"
#include "perception/stereo/wire.h"

namespace arpent {
namespace {

using namespace std::chrono_literals;

class PatchProcessTest : public testing::Test {
 protected:
  PatchProcessTest() {
    PatchConfig config;
    config.rig = ARPENT_SOURCE_DIR "/config/rigs/wifibot_stereo.yaml";
    config.source = "R3";
    const auto [bus, clock] = executor_.add_process(PatchProcess::kName);
    health_ = &bus.health();
    process_ = std::make_unique<PatchProcess>(config, bus, clock);
    executor_.set_tap([this](Time, const std::string& channel, BytesView bytes) {
      map_patch_t message;
      std::string fault;
      if (channel != channels::kMapPatch || !decode_guarded(bytes, message, fault)) return;
      const auto patch = mapping::from_wire(message);
      ASSERT_TRUE(patch) << patch.fault();
      patches_.push_back(*patch);
    });
  }

  void send_pair(fusion::Frame frame = fusion::Frame::kWorld, float depth_m = 2.0F) {
    executor_.run_until(executor_.now() + 200ms);
    const PinholeCamera camera{160, 128, 94.25, 94.25, 79.5, 63.5};
    stereo::StampedDepth depth;
    depth.stamp = executor_.now();
    depth.sequence = ++sequence_;
    depth.map = {camera, cv::Mat1f(128, 160, depth_m), cv::Mat1f(128, 160, 0.01F)};
    fusion::FusedPose pose;
    pose.stamp = executor_.now();
    pose.frame = frame;
    pose.status = fusion::Status::kOk;
    pose.covariance = Matrix6d::Identity() * 1e-4;
    pose.T_frame_body = Pose2{0.1 * static_cast<double>(sequence_), 0, 0}.to_pose();
    executor_.inject(executor_.now(), channels::kDepth, encode(stereo::to_wire(depth)));
    executor_.inject(executor_.now(), channels::kPairPose, encode(fusion::to_wire(pose, sequence_)));
    executor_.run_until(executor_.now() + 100ms);
  }

  LockstepExecutor executor_{Time{100s}};
  Health* health_ = nullptr;
  std::unique_ptr<PatchProcess> process_;
  std::vector<mapping::MapPatch> patches_;
  std::int64_t sequence_ = 0;
};

TEST_F(PatchProcessTest, FiveImagesBecomeOnePatchOfTheRobot) {
  for (int i = 0; i < 4; ++i) send_pair();
  EXPECT_TRUE(patches_.empty());
  send_pair();
  ASSERT_FALSE(patches_.empty());
  EXPECT_EQ(patches_.front().source, "R3");
  EXPECT_EQ(patches_.front().frame, "world");
  EXPECT_NEAR(patches_.front().position_sigma_m, 0.01, 1e-9);
  ASSERT_EQ(patches_.back().bodies.size(), 5U);
  EXPECT_NEAR(patches_.back().bodies[4].x_m, 0.5, 1e-9);
  mapping::TsdfMap map(mapping::TsdfParams{});
  for (const auto& patch : patches_) EXPECT_TRUE(mapping::fuse(map, patch));
  EXPECT_GT(map.known_voxel_count(), 1000U);
}

TEST_F(PatchProcessTest, WithoutAPoseInTheWorldThereIsNone) {
  for (int i = 0; i < 6; ++i) send_pair(fusion::Frame::kOdom);
  EXPECT_TRUE(patches_.empty());
  EXPECT_EQ(health_->counter(channels::kDepth, "rejected"), 6);
}

TEST_F(PatchProcessTest, WhereATeammateStandsNothingIsSaid) {
  robot_state_t mate{};
  mate.utime = to_utime(executor_.now());
  mate.robot = "R1";
  mate.x_m = 2.2;
  executor_.inject(executor_.now(), channels::kTeamState, encode(mate));
  for (int i = 0; i < 5; ++i) send_pair();
  EXPECT_GT(health_->counter("MASK", "pixels"), 100);
}

TEST_F(PatchProcessTest, GarbageIsCountedAndChangesNothing) {
  executor_.inject(executor_.now(), channels::kTeamState, Bytes(40, 0x5A));
  robot_state_t nobody{};
  executor_.inject(executor_.now(), channels::kTeamState, encode(nobody));
  executor_.inject(executor_.now(), channels::kDepth, Bytes(10, 1));
  executor_.run_until(executor_.now() + 1s);
  EXPECT_EQ(health_->counter(channels::kTeamState, "undecodable"), 1);
  EXPECT_EQ(health_->counter(channels::kTeamState, "invalid"), 1);
  EXPECT_EQ(health_->counter(channels::kDepth, "undecodable"), 1);
}

TEST(PatchWire, APatchSurvivesAndOneThatWasChangedOnTheWayIsRefused) {
  mapping::MapPatch patch;
  patch.source = "R1";
  patch.sequence = 7;
  patch.frame = "world";
  patch.newest = from_utime(8);
  patch.voxel_m = 0.1;
  patch.truncation_m = 0.3;
  patch.position_sigma_m = 0.04;
  patch.heading_sigma_rad = 0.05;
  patch.bodies = {{1, 2, 3}};
  patch.blocks = {1, 2, 3, 4};
  const auto back = mapping::from_wire(mapping::to_wire(patch));
  ASSERT_TRUE(back) << back.fault();
  EXPECT_EQ(back->source, patch.source);
  EXPECT_EQ(back->sequence, 7);
  EXPECT_EQ(back->frame, "world");
  EXPECT_EQ(back->newest, patch.newest);
  EXPECT_EQ(back->voxel_m, 0.1);
  EXPECT_EQ(back->truncation_m, 0.3);
  EXPECT_EQ(back->position_sigma_m, 0.04);
  EXPECT_EQ(back->heading_sigma_rad, 0.05);
  EXPECT_EQ(back->bodies, patch.bodies);
  EXPECT_EQ(back->blocks, patch.blocks);
  auto message = mapping::to_wire(patch);
  message.blocks[2] ^= 1;
  EXPECT_EQ(mapping::from_wire(message).fault(), "wrong checksum");
  message = mapping::to_wire(patch);
  message.body_x_m[0] = 1e9;
  EXPECT_FALSE(mapping::from_wire(message));
  message = mapping::to_wire(patch);
  message.sample = -1;
  EXPECT_FALSE(mapping::from_wire(message));
}

}  // namespace
}  // namespace arpent
