// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The feed's thread with sources that are scripts: absent, lost, silent, hanging.
#include "drivers/camera/feed.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace arpent::camera {
namespace {

using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;

struct Script {
  std::atomic<int> opened{0};
  std::atomic<bool> present{true};
  std::atomic<bool> sends{true};
  std::atomic<bool> hangs{false};
  std::atomic<int> exposure_us{0};
};

class ScriptedSource : public FrameSource {
 public:
  explicit ScriptedSource(std::shared_ptr<Script> script) : script_(std::move(script)) {}
  std::optional<Frame> next(Duration /*wait*/) override {
    std::this_thread::sleep_for(2ms);
    while (script_->hangs) std::this_thread::sleep_for(10ms);
    if (!script_->present) throw DeviceLost("pulled out");
    if (!script_->sends) return std::nullopt;
    Frame frame;
    frame.frame_id = ++id_;
    return frame;
  }
  void set_exposure(const ExposureSetting& setting) override { script_->exposure_us = setting.exposure_us; }
  bool answers() override { return script_->present; }

 private:
  std::shared_ptr<Script> script_;
  std::int64_t id_ = 0;
};

class CameraFeed : public testing::Test {
 protected:
  void start() {
    feed_ = std::make_unique<ThreadedFeed>(
        [script = script_]() -> std::unique_ptr<FrameSource> {
          ++script->opened;
          if (!script->present) throw DeviceLost("not there");
          return std::make_unique<ScriptedSource>(script);
        },
        params_);
  }
  template <class Done>
  bool wait(Done done) {
    const auto limit = Steady::now() + 3s;
    while (!done()) {
      if (Steady::now() > limit) return false;
      std::this_thread::sleep_for(2ms);
    }
    return true;
  }

  FeedParams params_{0.02, 0.2, 0.1};
  std::shared_ptr<Script> script_ = std::make_shared<Script>();
  std::unique_ptr<ThreadedFeed> feed_;
};

TEST_F(CameraFeed, DeliversFramesInOrderOfOneSession) {
  start();
  std::vector<Frame> frames;
  ASSERT_TRUE(wait([&] {
    for (Frame& f : feed_->take()) frames.push_back(std::move(f));
    return frames.size() >= 5;
  }));
  for (std::size_t i = 1; i < frames.size(); ++i) EXPECT_EQ(frames[i].frame_id, frames[i - 1].frame_id + 1);
  EXPECT_EQ(frames.back().session, 1);
  EXPECT_TRUE(feed_->condition().open);
  EXPECT_EQ(feed_->condition().fault, "");
}

TEST_F(CameraFeed, AMissingDeviceIsReportedAndTriedAgainLessAndLessOften) {
  script_->present = false;
  start();
  ASSERT_TRUE(wait([&] { return script_->opened >= 3; }));
  EXPECT_FALSE(feed_->condition().open);
  EXPECT_EQ(feed_->condition().fault, "not there");
  std::this_thread::sleep_for(600ms);
  EXPECT_LE(script_->opened, 9) << "20, 40, 80, 160, 200, 200 … ms apart, not always 20";
}

TEST_F(CameraFeed, APulledDeviceComesBackWithItsExposureInANewSession) {
  start();
  feed_->set_exposure({1234, 0});
  ASSERT_TRUE(wait([&] { return script_->exposure_us == 1234; }));
  script_->present = false;
  ASSERT_TRUE(wait([&] { return feed_->condition().fault != ""; }));
  (void)feed_->take();
  script_->exposure_us = 0;
  script_->present = true;
  std::vector<Frame> frames;
  ASSERT_TRUE(wait([&] { return !(frames = feed_->take()).empty(); }));
  EXPECT_EQ(frames.front().session, 2);
  EXPECT_EQ(script_->exposure_us, 1234);
  EXPECT_EQ(feed_->condition().openings, 2);
}

TEST_F(CameraFeed, ASilentDeviceThatAnswersIsKeptAndSaid) {
  script_->sends = false;
  start();
  ASSERT_TRUE(wait([&] { return feed_->condition().fault.find("triggered") != std::string::npos; }));
  EXPECT_TRUE(feed_->condition().open);
  EXPECT_EQ(script_->opened, 1);
  script_->sends = true;
  EXPECT_TRUE(wait([&] { return feed_->condition().fault.empty(); }));
}

TEST_F(CameraFeed, FramesThatNobodyTakesAreDroppedOldestFirstAndCounted) {
  start();
  ASSERT_TRUE(wait([&] { return feed_->condition().dropped >= 5; }));
  const auto frames = feed_->take();
  EXPECT_LE(frames.size(), 32U);
  EXPECT_GE(frames.front().frame_id, 6);
}

TEST_F(CameraFeed, ADriverThatHangsDoesNotHoldUsBack) {
  start();
  ASSERT_TRUE(wait([&] { return !feed_->take().empty(); }));
  script_->hangs = true;
  std::this_thread::sleep_for(50ms);
  const auto start_of_end = Steady::now();
  feed_.reset();
  EXPECT_LT(Steady::now() - start_of_end, 2s);
  script_->hangs = false;  // lets the thread go
}

}  // namespace
}  // namespace arpent::camera
