// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The whole stack of a robot behind cameras that lie: halves missing, black, frozen or swapped. On such images the
// wheels never move; in the middle of a drive they come to rest. The simulator stands in an executor of its own, and
// what it publishes is damaged on the way to the stack.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <arpent/can_frames_t.hpp>
#include <arpent/pose_t.hpp>

#include <functional>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "perception/stereo/wire.h"
#include "planning/wire.h"
#include "tools/mission/mission_file.h"
#include "tools/stack/lockstep_stack.h"

namespace arpent::tools {
namespace {

using namespace std::chrono_literals;
using stereo::StereoPair;

constexpr Time kStart{100s};

/// What is done to a pair before the stack gets it.
using Damage = std::function<void(StereoPair&)>;

class DamagedImages : public testing::Test {
 protected:
  DamagedImages() {
    stack_.add<BaseDriverProcess>(spec_.base);
    stack_.add<OdometryProcess>(spec_.odometry);
    stack_.add<TagProcess>(spec_.tags);
    stack_.add<PoseProcess>(spec_.pose);
    stack_.add<TrackerProcess>(spec_.tracker);
    stack_.add<MissionProcess>(spec_.mission);
    world_.add<SimProcess>(spec_.sim);
    world_.executor().set_tap(
        [this](Time, const std::string& channel, BytesView bytes) { from_world(channel, bytes); });
    stack_.executor().set_tap([this](Time, const std::string& channel, BytesView bytes) {
      if (channel == channels::kCan && decoded<can_frames_t>(bytes).sender == "driver")
        to_world_.push_back(copy(bytes));
    });
    stack_.executor().inject(kStart + 500ms, channels::kMissionCommand,
                             encode(planning::to_wire(kStart, {planning::MissionCommand::kStart, "test"})));
  }

  static MissionSpec mission() {
    MissionOverrides overrides;
    overrides.settings = {"pose.fusion.max_dead_reckoning_m=0.05"};
    return load_mission(ARPENT_SOURCE_DIR "/config/missions/square.yaml", overrides);
  }
  static Bytes copy(BytesView bytes) { return {bytes.begin(), bytes.end()}; }
  template <class Message>
  static Message decoded(BytesView bytes) {
    Message message;
    std::string fault;
    EXPECT_TRUE(decode_guarded(bytes, message, fault)) << fault;
    return message;
  }
  void from_world(const std::string& channel, BytesView bytes) {
    if (channel == channels::kTruthPose) {
      const auto truth = decoded<pose_t>(bytes);
      truth_m_ = {truth.position_m[0], truth.position_m[1]};
    } else if (channel == channels::kStereoImages) {
      StereoPair pair = *stereo::from_wire(decoded<stereo_images_t>(bytes));
      ++pairs_;
      if (damage_) damage_(pair);
      to_stack_.emplace_back(channel, encode(stereo::to_wire(pair, false)));
    } else {
      to_stack_.emplace_back(channel, copy(bytes));
    }
  }
  void run(Duration duration) {
    for (const Time end = stack_.executor().now() + duration; stack_.executor().now() < end;) {
      const Time next = stack_.executor().now() + 10ms;
      for (const Bytes& bytes : std::exchange(to_world_, {})) {
        world_.executor().inject(world_.executor().now(), channels::kCan, bytes);
      }
      world_.executor().run_until(next);
      for (const auto& [channel, bytes] : std::exchange(to_stack_, {})) {
        stack_.executor().inject(stack_.executor().now(), channel, bytes);
      }
      stack_.executor().run_until(next);
    }
  }
  /// How far the robot is from where it was.
  double way_m(const Eigen::Vector2d& from_m) const { return (truth_m_ - from_m).norm(); }
  std::int64_t counted(const char* process, const char* counter) const {
    const auto figures = stack_.figures();
    const auto& counters = figures.at(process).counters;
    const auto found = counters.find(std::string(channels::kStereoImages) + "." + counter);
    return found == counters.end() ? 0 : found->second;
  }
  void expect_never_moves(const Damage& damage) {
    damage_ = damage;
    run(100ms);
    const Eigen::Vector2d start_m = truth_m_;
    run(4s);
    EXPECT_EQ(way_m(start_m), 0);
    EXPECT_GE(pairs_, 20);
    EXPECT_GE(counted(OdometryProcess::kName, "invalid"), pairs_ - 2) << "each is counted, but perhaps the first";
  }

  MissionSpec spec_ = mission();
  LockstepStack world_{kStart, 1};
  LockstepStack stack_{kStart, 2};
  std::vector<Bytes> to_world_;
  std::vector<std::pair<std::string, Bytes>> to_stack_;
  Damage damage_;
  std::int64_t pairs_ = 0;
  Eigen::Vector2d truth_m_ = Eigen::Vector2d::Zero();
};

TEST_F(DamagedImages, BlackOnesMoveNothing) {
  expect_never_moves([](StereoPair& pair) {
    pair.left.setTo(0);
    pair.right.setTo(0);
  });
}

TEST_F(DamagedImages, AHalfIsNoPairAndMovesNothing) {
  expect_never_moves([](StereoPair& pair) { pair.right = cv::Mat1b(1, 1, std::uint8_t{0}); });
}

TEST_F(DamagedImages, OneThatStandsInForBothMovesNothing) {
  expect_never_moves([](StereoPair& pair) { pair.right = pair.left.clone(); });
}

TEST_F(DamagedImages, FrozenOnesMoveNothing) {
  expect_never_moves([first = std::make_shared<StereoPair>()](StereoPair& pair) {
    if (first->left.empty()) *first = pair;
    pair.left = first->left;
    pair.right = first->right;
  });
}

TEST_F(DamagedImages, SwappedOnesMoveNothing) {
  damage_ = [](StereoPair& pair) { std::swap(pair.left, pair.right); };
  run(100ms);
  const Eigen::Vector2d start_m = truth_m_;
  run(4s);
  EXPECT_EQ(way_m(start_m), 0);
}

/// Wheels and gyro carry it on blindly until their own error is past a bound (here a tighter one than usual).
TEST_F(DamagedImages, SoundOnesDriveAndWithoutThemItComesToRest) {
  run(100ms);
  const Eigen::Vector2d start_m = truth_m_;
  for (int i = 0; i < 20 && way_m(start_m) < 0.5; ++i) run(500ms);
  ASSERT_GE(way_m(start_m), 0.5) << "the same stack, told the truth";
  damage_ = [](StereoPair& pair) { pair.left.setTo(0), pair.right.setTo(0); };
  double blind_m = 0;
  double step_m = 1;
  for (int i = 0; i < 30 && step_m > 0; ++i) {
    const Eigen::Vector2d before_m = truth_m_;
    run(500ms);
    step_m = way_m(before_m);
    blind_m += step_m;
  }
  EXPECT_EQ(step_m, 0);
  EXPECT_GT(blind_m, 0.5) << "it does not stop for a single bad pair";
  EXPECT_LT(blind_m, 6);
  const Eigen::Vector2d end_m = truth_m_;
  run(2s);
  EXPECT_EQ(way_m(end_m), 0) << "and stays";
}

}  // namespace
}  // namespace arpent::tools
