// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The three processes on the in-memory bus: what they publish, and what they do with input that is late, absent or
// garbage.
#include <gtest/gtest.h>

#include <arpent/depth_t.hpp>
#include <arpent/map_status_t.hpp>
#include <arpent/odometry_t.hpp>
#include <filesystem>

#include "common/atomic_file.h"
#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/error.h"
#include "common/pose2.h"
#include "mapping/process/mapping_process.h"
#include "mapping/tsdf/storage.h"
#include "mapping/wire.h"
#include "perception/fusion/wire.h"
#include "perception/odometry/wire.h"
#include "perception/process/depth_process.h"
#include "perception/process/odometry_process.h"
#include "perception/stereo/wire.h"
#include "sim/sequence.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;

/// A half-size rig, its rendered pairs, and the three processes on one bus.
class ProcessesTest : public testing::Test {
 protected:
  ProcessesTest() {
    fs::create_directories(folder_);
    RigConfig rig = config::load<RigConfig>(ARPENT_SOURCE_DIR "/config/rigs/wifibot_stereo.yaml");
    for (RigCamera* camera : {&rig.left, &rig.right}) {
      *camera = {320, 256, 188.5, 188.5, 159.5, 127.5, "none", {}};
    }
    atomic_write(rig_file_, config::to_yaml(rig));
    const StereoCalibration calibration = to_calibration(rig, "rig");
    stereo_ = {calibration.left.pinhole, 0.26};
    T_body_cam_ = calibration.T_body_left;
    DepthConfig depth;
    depth.rig = rig_file_;
    OdometryConfig odometry;
    odometry.rig = rig_file_;
    MappingConfig mapping;
    mapping.rig = rig_file_;
    mapping.map_file = folder_ / "map";
    mapping.mesh_file = folder_ / "mesh.ply";
    const auto [depth_bus, depth_clock] = executor_.add_process("depth_process");
    depth_ = std::make_unique<DepthProcess>(depth, depth_bus, depth_clock);
    depth_health_ = &depth_bus.health();
    const auto [odometry_bus, odometry_clock] = executor_.add_process("odometry_process");
    odometry_ = std::make_unique<OdometryProcess>(odometry, odometry_bus, odometry_clock);
    odometry_health_ = &odometry_bus.health();
    const auto [mapping_bus, mapping_clock] = executor_.add_process("mapping_process");
    mapping_ = std::make_unique<MappingProcess>(mapping, mapping_bus, mapping_clock);
    mapping_health_ = &mapping_bus.health();
    executor_.set_tap([this](Time, const std::string& channel, BytesView bytes) {
      seen_[channel].emplace_back(bytes.begin(), bytes.end());
    });
  }
  ~ProcessesTest() override { fs::remove_all(folder_); }

  stereo::StereoPair pair(int number) const {
    const auto drive = sim::make_arena_drive(0.2 * number, 5, Time(std::chrono::seconds(100)));
    const auto rendered =
        sim::render_pair(scene_, stereo_, T_body_cam_, drive.back(), static_cast<std::uint64_t>(number));
    return {rendered.pose.stamp, number, rendered.left, rendered.right};
  }
  void play(const stereo::StereoPair& p, bool png = false) { inject(p.stamp, stereo::to_wire(p, png)); }
  template <class Message>
  void inject(Time time, const Message& message) {
    executor_.inject(time, channels::kStereoImages, encode(message));
    executor_.run_until_idle();
  }
  template <class Message>
  std::vector<Message> received(const char* channel) const {
    std::vector<Message> messages;
    const auto found = seen_.find(channel);
    if (found == seen_.end()) return messages;
    for (const Bytes& bytes : found->second) {
      std::string fault;
      messages.emplace_back();
      EXPECT_TRUE(decode_guarded(bytes, messages.back(), fault)) << fault;
    }
    return messages;
  }

  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("processes_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  fs::path rig_file_ = folder_ / "rig.yaml";
  sim::Scene scene_ = sim::make_test_arena();
  RectifiedStereo stereo_;
  Pose T_body_cam_;
  LockstepExecutor executor_{Time(std::chrono::seconds(100))};
  std::unique_ptr<DepthProcess> depth_;
  std::unique_ptr<OdometryProcess> odometry_;
  std::unique_ptr<MappingProcess> mapping_;
  Health* depth_health_ = nullptr;
  Health* odometry_health_ = nullptr;
  Health* mapping_health_ = nullptr;
  std::map<std::string, std::vector<Bytes>> seen_;
};

TEST_F(ProcessesTest, EachPairGivesDepthOdometryAndAMapState) {
  for (int i = 0; i < 4; ++i) play(pair(i), i % 2 == 0);
  EXPECT_EQ(received<depth_t>(channels::kDepth).size(), 4U);
  EXPECT_EQ(received<odometry_t>(channels::kOdometry).size(), 4U);
  const auto states = received<map_status_t>(channels::kMapStatus);
  ASSERT_EQ(states.size(), 4U);
  EXPECT_EQ(states.back().integrated, 4);
  EXPECT_EQ(states.back().utime, to_utime(pair(3).stamp));
  EXPECT_EQ(states.back().odometry_utime, states.back().utime);
  EXPECT_GT(states.back().block_count, 10);
}

/// PAIR_POSE says the truth; the map lies where it says.
TEST_F(ProcessesTest, WithPairPosesTheMapLiesInTheWorldAndWaitsForIt) {
  MappingConfig config;
  config.rig = rig_file_;
  config.pose_source = "pair_pose";
  const auto [bus, clock] = executor_.add_process("mapping_in_world");
  MappingProcess mapping(config, bus, clock);
  const auto give_pose = [&](int number, const char* frame) {
    fusion::FusedPose pose;
    pose.stamp = pair(number).stamp;
    pose.T_frame_body = Pose2{2.7, 3.5, 1.6}.to_pose();
    pose.frame = std::string(frame) == "world" ? fusion::Frame::kWorld : fusion::Frame::kOdom;
    pose.status = fusion::Status::kOk;
    executor_.inject(pose.stamp, channels::kPairPose, encode(fusion::to_wire(pose, number)));
  };
  give_pose(0, "odom");
  play(pair(0));
  EXPECT_EQ(mapping.map().block_count(), 0U) << "not aligned yet";
  EXPECT_EQ(bus.health().counter(channels::kDepth, "rejected"), 1);
  give_pose(1, "world");
  play(pair(1));
  EXPECT_GT(mapping.map().block_count(), 10U);
  for (const auto& block : mapping.map().storage().blocks) {
    const Eigen::Vector3d centre = mapping.map().centre_m(8 * block->index);
    EXPECT_GT(centre.y(), 2.0) << "the camera looks along +y from y = 3.5";
  }
}

TEST_F(ProcessesTest, TheMapIsSavedAtAnOrderlyEnd) {
  play(pair(0));
  mapping_->finish();
  EXPECT_TRUE(fs::exists(folder_ / "map"));
  EXPECT_GT(read_ply(folder_ / "mesh.ply").triangles.size(), 100U);
}

TEST_F(ProcessesTest, PairsFasterThanTheRateGiveOdometryButNoDepth) {
  stereo::StereoPair p = pair(0);
  play(p);
  p.stamp += std::chrono::milliseconds(100);  // 10 Hz where 5 Hz are wanted
  ++p.sequence;
  play(p);
  EXPECT_EQ(received<odometry_t>(channels::kOdometry).size(), 2U);
  EXPECT_EQ(received<depth_t>(channels::kDepth).size(), 1U);
}

TEST_F(ProcessesTest, APairThatCannotBeUsedGivesALostOdometryAndNoDepth) {
  play(pair(0));
  const auto expect_refused = [&](int number, const std::function<void(stereo::StereoPair&)>& damage) {
    stereo::StereoPair bad = pair(number);
    damage(bad);
    play(bad);
    const auto odometry = received<odometry_t>(channels::kOdometry);
    ASSERT_EQ(odometry.size(), static_cast<std::size_t>(number) + 1);
    EXPECT_EQ(odometry.back().status, odometry_t::STATUS_LOST);
    EXPECT_FALSE(odometry.back().reason.empty());
  };
  expect_refused(1, [](auto& p) { p.left.setTo(0); });
  expect_refused(2, [](auto& p) { p.right.setTo(255); });
  expect_refused(3, [](auto& p) { p.right = p.left.clone(); });
  expect_refused(4, [](auto& p) { p.left = p.right = cv::Mat1b(64, 64, std::uint8_t{90}); });
  EXPECT_EQ(received<depth_t>(channels::kDepth).size(), 1U);
  EXPECT_EQ(odometry_health_->counter(channels::kStereoImages, "invalid"), 4);
  EXPECT_EQ(depth_health_->counter(channels::kStereoImages, "invalid"), 4);
  play(pair(5));
  EXPECT_EQ(received<depth_t>(channels::kDepth).size(), 2U) << "a good pair works again";
}

TEST_F(ProcessesTest, ImagesOfDifferentSizesOrAWrongChecksumAreCountedAndDropped) {
  play(pair(0));
  stereo_images_t unequal = stereo::to_wire(pair(1), false);
  unequal.right = stereo::to_wire({Time(), 0, cv::Mat1b(10, 10), cv::Mat1b(10, 10)}, false).left;
  inject(pair(1).stamp, unequal);
  stereo_images_t flipped = stereo::to_wire(pair(2), true);
  flipped.left.data[100] ^= 1;
  inject(pair(2).stamp, flipped);
  EXPECT_EQ(depth_health_->counter(channels::kStereoImages, "invalid"), 2);
  EXPECT_EQ(received<odometry_t>(channels::kOdometry).size(), 3U);
}

TEST_F(ProcessesTest, GarbageIsCountedByEveryProcessAndHarmsNone) {
  play(pair(0));
  for (const char* channel : {channels::kStereoImages, channels::kDepth, channels::kOdometry}) {
    executor_.inject(executor_.now(), channel, Bytes(1000, 0xAB));
    executor_.inject(executor_.now(), channel, Bytes{});
  }
  executor_.run_until_idle();
  EXPECT_EQ(depth_health_->counter(channels::kStereoImages, "undecodable"), 2);
  EXPECT_EQ(odometry_health_->counter(channels::kStereoImages, "undecodable"), 2);
  EXPECT_EQ(mapping_health_->counter(channels::kDepth, "undecodable"), 2);
  EXPECT_EQ(mapping_health_->counter(channels::kOdometry, "undecodable"), 2);
  play(pair(1));
  EXPECT_EQ(received<map_status_t>(channels::kMapStatus).size(), 2U);
}

TEST_F(ProcessesTest, LostPairsAreCountedFromTheirSequence) {
  play(pair(0));
  play(pair(4));
  EXPECT_EQ(odometry_health_->counter(channels::kStereoImages, "lost"), 3);
}

TEST_F(ProcessesTest, DepthIsNotFusedWhereOdometryIsLost) {
  play(pair(0));
  const auto depth = received<depth_t>(channels::kDepth).back();
  const auto odometry = received<odometry_t>(channels::kOdometry).back();
  depth_t later = depth;
  later.utime += 1'000'000;
  odometry_t lost = odometry;
  lost.utime += 1'000'000;
  lost.status = odometry_t::STATUS_LOST;
  executor_.inject(executor_.now(), channels::kDepth, encode(later));
  executor_.inject(executor_.now(), channels::kOdometry, encode(lost));
  executor_.run_until_idle();
  EXPECT_EQ(received<map_status_t>(channels::kMapStatus).size(), 1U);
  EXPECT_EQ(mapping_health_->counter(channels::kDepth, "rejected"), 1);
}

TEST(ProcessConfig, ARigThatIsNotThereOrUnusableIsOneClearError) {
  LockstepExecutor executor{Time()};
  const auto [bus, clock] = executor.add_process("p");
  DepthConfig config;
  config.rig = "/no/such/rig.yaml";
  EXPECT_THROW(DepthProcess(config, bus, clock), InputError);
}

}  // namespace
}  // namespace arpent
