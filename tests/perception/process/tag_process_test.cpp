// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// tag_process on the in-memory bus, with pictures of the cube and odometry from its own frame.
#include "perception/process/tag_process.h"

#include <gtest/gtest.h>

#include <map>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/config.h"
#include "common/error.h"
#include "perception/odometry/wire.h"
#include "perception/stereo/wire.h"
#include "perception/tags/wire.h"
#include "tests/perception/tags/cube_pictures.h"

namespace arpent {
namespace {

using std::chrono::milliseconds;

class TagProcessTest : public testing::Test {
 protected:
  TagProcessTest() {
    TagConfig config;
    config.rig = ARPENT_SOURCE_DIR "/config/rigs/wifibot_stereo.yaml";
    config.alignment.max_views = 10;
    const auto [bus, clock] = executor_.add_process("tag_process");
    process_ = std::make_unique<TagProcess>(config, bus, clock);
    health_ = &bus.health();
    executor_.set_tap([this](Time, const std::string& channel, BytesView bytes) {
      seen_[channel].emplace_back(bytes.begin(), bytes.end());
    });
  }

  static Time time_of(int number) { return Time(std::chrono::seconds(100)) + milliseconds(200 * number); }
  /// The robot turns a little while it stands at 1.5 m.
  static Pose T_world_body(int number) { return tags::pose_facing({}, 1.5, 2.2, 0.01 * number); }

  stereo::StereoPair pair(int number, const tags::PictureOptions& options = {}) const {
    const auto picture = tags::render_cube({}, T_world_body(number), static_cast<std::uint64_t>(number), options);
    return {time_of(number), number, picture.left, picture.right};
  }
  void play(const stereo::StereoPair& p) { inject(p.stamp, channels::kStereoImages, stereo::to_wire(p, false)); }
  void play_odometry(int number, odometry::Status status = odometry::Status::kOk) {
    odometry::BodyOdometry odometry;
    odometry.stamp = time_of(number);
    odometry.sequence = number;
    odometry.T_odom_body = T_world_odom_.inverse() * T_world_body(number);
    odometry.covariance = 1e-8 * Matrix6d::Identity();
    odometry.status = status;
    inject(odometry.stamp + milliseconds(60), channels::kOdometry, to_wire(odometry));
  }
  void step(int number) {
    play(pair(number));
    play_odometry(number);
  }
  template <class Message>
  void inject(Time time, const char* channel, const Message& message) {
    executor_.inject(std::max(time, executor_.now()), channel, encode(message));
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
  std::vector<tag_observation_t> observations() const { return received<tag_observation_t>(channels::kTagObservation); }
  std::vector<frame_alignment_t> alignments() const { return received<frame_alignment_t>(channels::kFrameAlignment); }

  Pose T_world_odom_ = T_world_body(0);
  LockstepExecutor executor_{Time(std::chrono::seconds(100))};
  std::unique_ptr<TagProcess> process_;
  Health* health_ = nullptr;
  std::map<std::string, std::vector<Bytes>> seen_;
};

TEST_F(TagProcessTest, ObservesEachPairAndAlignsAfterFive) {
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(alignments().empty());
    step(i);
  }
  ASSERT_EQ(observations().size(), 5U);
  const auto observed = tags::from_wire(observations().back());
  ASSERT_TRUE(observed) << observed.fault();
  EXPECT_TRUE(observed->accepted) << observed->reason;
  EXPECT_EQ(observed->stamp, time_of(4));
  EXPECT_EQ(observed->sequence, 4);
  EXPECT_LT(local(T_world_body(4), observed->T_world_body).norm(), 0.01);
  ASSERT_EQ(alignments().size(), 1U);
  const auto aligned = tags::from_wire(alignments().back());
  ASSERT_TRUE(aligned) << aligned.fault();
  EXPECT_EQ(aligned->stamp, time_of(4));
  EXPECT_EQ(aligned->views, 5);
  EXPECT_LT(local(T_world_odom_, aligned->T_world_odom).norm(), 0.01);
}

TEST_F(TagProcessTest, OnceAlignedItLooksOnceASecond) {
  for (int i = 0; i < 10; ++i) step(i);
  EXPECT_EQ(alignments().size(), 2U) << "five views, ten views";
  const std::size_t before = observations().size();
  for (int i = 10; i < 20; ++i) step(i);
  EXPECT_EQ(observations().size() - before, 2U) << "of ten pairs in two seconds";
  EXPECT_EQ(alignments().size(), 2U);
}

TEST_F(TagProcessTest, TheOrderOfPairsAndOdometryDoesNotMatter) {
  for (int i = 0; i < 5; ++i) play_odometry(i);
  for (int i = 0; i < 5; ++i) play(pair(i));
  EXPECT_EQ(alignments().size(), 1U);
}

TEST_F(TagProcessTest, PairsFasterThanTheRateArePassedOver) {
  stereo::StereoPair p = pair(0);
  play(p);
  p.stamp += milliseconds(100);
  ++p.sequence;
  play(p);
  EXPECT_EQ(observations().size(), 1U);
}

TEST_F(TagProcessTest, WithoutATagNothingIsSaidAndForeignTagsAreReportedButNotUsed) {
  tags::PictureOptions options;
  options.with_cube = false;
  play(pair(0, options));
  EXPECT_TRUE(observations().empty());
  options.with_cube = true;
  options.painted_ids = {10, 11, 12, 13};
  play(pair(1, options));
  ASSERT_EQ(observations().size(), 1U);
  EXPECT_EQ(observations()[0].accepted, 0);
  EXPECT_FALSE(observations()[0].reason.empty());
  EXPECT_EQ(health_->counter(channels::kTagObservation, "rejected"), 1);
}

TEST_F(TagProcessTest, ALostOdometryStartsTheAlignmentAnew) {
  for (int i = 0; i < 5; ++i) step(i);
  ASSERT_EQ(alignments().size(), 1U);
  play(pair(5));
  play_odometry(5, odometry::Status::kLost);
  EXPECT_EQ(health_->counter(channels::kTagObservation, "without odometry"), 1);
  T_world_odom_ = retract(T_world_odom_, (Vector6d() << 0.5, 0.2, 0, 0, 0, 0.3).finished());
  for (int i = 6; i < 10; ++i) step(i);
  EXPECT_EQ(alignments().size(), 1U);
  step(10);
  ASSERT_EQ(alignments().size(), 2U);
  const auto aligned = tags::from_wire(alignments().back());
  ASSERT_TRUE(aligned) << aligned.fault();
  EXPECT_LT(local(T_world_odom_, aligned->T_world_odom).norm(), 0.01);
}

TEST_F(TagProcessTest, WhatCannotBeUsedIsCountedAndTheNextPairWorks) {
  stereo::StereoPair bad = pair(0);
  bad.left.setTo(0);
  play(bad);
  bad = pair(1);
  bad.right = bad.left.clone();
  play(bad);
  bad = pair(2);
  bad.left = bad.right = cv::Mat1b(64, 64, std::uint8_t{90});
  play(bad);
  EXPECT_EQ(health_->counter(channels::kStereoImages, "invalid"), 3);
  executor_.inject(executor_.now(), channels::kStereoImages, Bytes{1, 2, 3});
  executor_.inject(executor_.now(), channels::kOdometry, Bytes(200, 7));
  executor_.run_until_idle();
  EXPECT_EQ(health_->counter(channels::kStereoImages, "undecodable"), 1);
  EXPECT_EQ(health_->counter(channels::kOdometry, "undecodable"), 1);
  odometry::BodyOdometry odometry;
  odometry_t wrong = to_wire(odometry);
  wrong.frame = "world";
  inject(time_of(3), channels::kOdometry, wrong);
  EXPECT_EQ(health_->counter(channels::kOdometry, "invalid"), 1);
  EXPECT_TRUE(observations().empty());
  step(4);
  EXPECT_EQ(observations().size(), 1U);
}

TEST(TagProcess, RefusesAConfigThatCannotBe) {
  LockstepExecutor executor{Time(std::chrono::seconds(1))};
  const auto [bus, clock] = executor.add_process("tag_process");
  TagConfig config;
  config.rig = ARPENT_SOURCE_DIR "/config/rigs/wifibot_stereo.yaml";
  EXPECT_NO_THROW(TagProcess(config, bus, clock));
  config.cube.ids = {1, 1, 2, 3};
  EXPECT_THROW(TagProcess(config, bus, clock), InputError);
  config.cube = {};
  config.rig = "nowhere.yaml";
  EXPECT_THROW(TagProcess(config, bus, clock), InputError);
}

}  // namespace
}  // namespace arpent
