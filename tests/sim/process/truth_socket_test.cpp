// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// What simulators in processes of their own tell each other arrives, from teammates alone, and never blocks; and a
// robot that hears so of a teammate sees it.
#include "sim/process/truth_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "perception/stereo/wire.h"
#include "sim/process/sim_process.h"
#include "sim/wire.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

cv::Mat1f depth_in(BytesView bytes) {
  depth_t message;
  std::string fault;
  EXPECT_TRUE(decode_guarded(bytes, message, fault)) << fault;
  const auto depth = stereo::from_wire(message);
  EXPECT_TRUE(depth);
  return depth->map.depth_m.clone();
}

/// Pixels that are nearer by a hand's breadth or more.
int nearer(const cv::Mat1f& before_m, const cv::Mat1f& after_m) {
  return cv::countNonZero((before_m > 0) & (after_m > 0) & (after_m + 0.15F < before_m));
}

class TruthSocketTest : public testing::Test {
 protected:
  TruthSocketTest() { fs::create_directories(folder_); }
  ~TruthSocketTest() override { fs::remove_all(folder_); }

  static std::vector<std::pair<std::string, Bytes>> received(const TruthSocket& socket) {
    std::vector<std::pair<std::string, Bytes>> all;
    socket.receive([&](const std::string& teammate, BytesView bytes) {
      all.emplace_back(teammate, Bytes(bytes.begin(), bytes.end()));
    });
    return all;
  }

  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("truth_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(TruthSocketTest, EverybodyHearsTheOthersInOrder) {
  const TruthSocket r1(folder_, "R1", {"R2", "R3"}), r2(folder_, "R2", {"R1", "R3"}), r3(folder_, "R3", {"R1", "R2"});
  r1.send(Bytes{1});
  r1.send(Bytes{2});
  r3.send(Bytes{3});
  EXPECT_THAT(received(r1), ElementsAre(Pair("R3", Bytes{3})));
  EXPECT_THAT(received(r2), ElementsAre(Pair("R1", Bytes{1}), Pair("R1", Bytes{2}), Pair("R3", Bytes{3})));
  EXPECT_THAT(received(r2), IsEmpty());
}

TEST_F(TruthSocketTest, StrangersAreNotHeard) {
  const TruthSocket r1(folder_, "R1", {"R2"}), stranger(folder_, "R9", {"R1"});
  stranger.send(Bytes{1});
  EXPECT_THAT(received(r1), IsEmpty());
}

TEST_F(TruthSocketTest, WhoIsNotThereOrDoesNotReadHoldsNobodyUp) {
  const TruthSocket r1(folder_, "R1", {"R2"});
  r1.send(Bytes{1});
  const TruthSocket r2(folder_, "R2", {"R1"});
  for (int i = 0; i < 10000; ++i) r1.send(Bytes{2});
  const auto all = received(r2);
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(all.front().second, Bytes{2});
}

TEST_F(TruthSocketTest, ASocketThatCannotBeIsOneClearError) {
  EXPECT_THROW(TruthSocket(folder_ / "nowhere", "R1", {}), InputError);
  EXPECT_THROW(TruthSocket(folder_ / std::string(200, 'x'), "R1", {}), InputError);
}

TEST_F(TruthSocketTest, TheSimulatorTellsEachCycleAndSeesATeammate) {
  SimConfig config;
  config.world = ARPENT_SOURCE_DIR "/config/worlds/test_arena.yaml";
  config.robot = ARPENT_SOURCE_DIR "/config/robots/wifibot.yaml";
  config.sensing = "depth";
  config.start = 2;
  config.teammates = "R2";
  config.name = "R1";
  config.truth_folder = folder_;
  LockstepExecutor executor(Time(100s), 1);
  const auto [bus, clock] = executor.add_process(SimProcess::kName);
  std::map<std::string, int> seen;
  std::optional<pose_t> truth;
  cv::Mat1f depth_m, before_m;
  executor.set_tap([&](Time, const std::string& channel, BytesView bytes) {
    ++seen[channel];
    std::string fault;
    pose_t message;
    if (channel == channels::kTruthPose && decode_guarded(bytes, message, fault)) truth = message;
    if (channel == channels::kDepth) depth_m = depth_in(bytes);
  });
  const SimProcess sim(config, bus, clock);
  const TruthSocket r2(folder_, "R2", {"R1"});
  std::vector<std::pair<std::string, Bytes>> heard;
  for (Time until{100s}; until <= Time(101s); until += 100ms) {
    executor.run_until(until);
    for (auto& message : received(r2)) heard.push_back(std::move(message));
  }
  ASSERT_TRUE(truth.has_value());
  EXPECT_EQ(heard.size(), static_cast<std::size_t>(seen[channels::kTruthPose])) << "each cycle is told";
  EXPECT_EQ(heard.back().second, encode(*truth)) << "the same as is logged, and nothing else";
  EXPECT_EQ(seen.count("R2/TRUTH_POSE"), 0U) << "nothing of it is on the robot's bus";

  before_m = depth_m;
  executor.run_until(Time(102s));
  EXPECT_LT(nearer(before_m, depth_m), 500) << "noise";
  // From now on a teammate stands before it.
  pose_t mate = *truth;
  const double yaw_rad = 2 * std::atan2(mate.orientation_wxyz[3], mate.orientation_wxyz[0]);
  mate.position_m[0] += 1.5 * std::cos(yaw_rad);
  mate.position_m[1] += 1.5 * std::sin(yaw_rad);
  r2.send(encode(mate));
  executor.run_until(Time(103s));
  EXPECT_GT(nearer(before_m, depth_m), 5000);
}

}  // namespace
}  // namespace arpent
