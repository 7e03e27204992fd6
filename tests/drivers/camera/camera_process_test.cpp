// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// camera_process: from a folder in lockstep; and from two GigE Vision cameras that we serve, over the live bus, in a
// network of our own, with a camera that is missing, pulled and plugged again.
#include "drivers/camera/process/camera_process.h"

#include <gtest/gtest.h>

#include <arpent/stereo_images_t.hpp>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "common/bus/lcm_bus.h"
#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/config.h"
#include "common/error.h"
#include "common/image_codec.h"
#include "common/net/private_network.h"
#include "drivers/camera/gv_server.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;

cv::Mat1b image_of(const image_t& message) {
  auto image = decode_image(message);
  EXPECT_TRUE(image) << image.fault();
  return image ? cv::Mat1b(*image) : cv::Mat1b(1, 1, std::uint8_t{0});
}

// Lockstep.

class CameraProcessLockstep : public testing::Test {
 protected:
  CameraProcessLockstep() { fs::create_directories(folder_); }
  ~CameraProcessLockstep() override { fs::remove_all(folder_); }

  void write(const std::string& name, int level) {
    cv::imwrite((folder_ / name).string(), cv::Mat1b(4, 6, static_cast<std::uint8_t>(level)));
  }
  CameraConfig config() const {
    CameraConfig config;
    config.source = "folder";
    config.folder.path = folder_;
    return config;
  }
  /// The messages of `duration`, as bytes.
  std::vector<Bytes> run(Duration duration, Health::Condition* condition = nullptr) {
    LockstepExecutor executor{Time(100s)};
    std::vector<Bytes> messages;
    executor.set_tap([&](Time, const std::string& channel, BytesView bytes) {
      EXPECT_EQ(channel, channels::kStereoImages);
      messages.emplace_back(bytes.begin(), bytes.end());
    });
    const auto [bus, clock] = executor.add_process("camera_process");
    CameraProcess process(config(), bus, clock);
    executor.run_until(Time(100s) + duration);
    if (condition != nullptr) *condition = bus.health().take_condition();
    process.finish();
    return messages;
  }
  static stereo_images_t decode(const Bytes& bytes) {
    stereo_images_t message;
    std::string fault;
    EXPECT_TRUE(decode_guarded(bytes, message, fault)) << fault;
    return message;
  }

  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("camera_process_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(CameraProcessLockstep, AFolderIsPlayedAsPairsWithItsTimesAndTheSameBytesEachTime) {
  for (int i = 0; i < 4; ++i) {
    write("left" + std::to_string(i) + ".png", 10 + i);
    write("right" + std::to_string(i) + ".png", 20 + i);
  }
  const auto messages = run(2s);
  ASSERT_EQ(messages.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    const stereo_images_t pair = decode(messages[static_cast<std::size_t>(i)]);
    EXPECT_EQ(pair.sequence, i);
    EXPECT_EQ(pair.utime, 100'000'000 + 200'000 * i);
    EXPECT_EQ(image_of(pair.left)(3, 5), 10 + i);
    EXPECT_EQ(image_of(pair.right)(0, 0), 20 + i);
    EXPECT_EQ(pair.left.compression, image_t::COMPRESSION_NONE);
  }
  EXPECT_EQ(run(2s), messages);
}

TEST_F(CameraProcessLockstep, AFolderThatEndsLeavesTheRobotBlindAndThatIsSaid) {
  write("left0.png", 1), write("right0.png", 2);
  Health::Condition condition;
  EXPECT_EQ(run(3s, &condition).size(), 1U);
  EXPECT_EQ(condition.level, Health::Level::kError);
  EXPECT_NE(condition.message.find("no stereo pair"), std::string::npos) << condition.message;
}

TEST_F(CameraProcessLockstep, AnImageThatCannotBeReadCostsItsPairAndShowsAsAGapInTheSequence) {
  for (int i = 0; i < 3; ++i) {
    write("left" + std::to_string(i) + ".png", 10);
    write("right" + std::to_string(i) + ".png", 20);
  }
  std::ofstream(folder_ / "right1.png") << "this is no image";
  const auto messages = run(2s);
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(decode(messages[0]).sequence, 0);
  EXPECT_EQ(decode(messages[1]).sequence, 2);
}

TEST(CameraProcessConfig, WhatCanNeverWorkIsRefusedWithEveryFault) {
  LockstepExecutor executor{Time(1s)};
  const auto [bus, clock] = executor.add_process("p");
  const auto fault = [&bus = bus, &clock = clock](const CameraConfig& config) {
    try {
      const CameraProcess process(config, bus, clock);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CameraConfig config;
  config.exposure.mode = "device";
  const std::string text = fault(config);
  for (const char* key : {"left_device", "right_device", "exposure.mode"}) {
    EXPECT_NE(text.find(key), std::string::npos) << text;
  }
  config = {};
  config.left_device = config.right_device = "10.0.0.1";
  EXPECT_NE(fault(config).find("another"), std::string::npos);
  config.layout = "side_by_side";
  EXPECT_NE(fault(config).find("v4l2"), std::string::npos);
  config = {};
  config.source = "v4l2";
  config.left_device = "/dev/video0";
  config.right_device = "/dev/video1";
  EXPECT_NE(fault(config).find("max_gain_db"), std::string::npos);
}

TEST(CameraProcessConfig, EveryShippedFileLoadsAndPrintsBack) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(ARPENT_SOURCE_DIR "/config/cameras")) {
    const auto loaded = config::load<CameraConfig>(entry.path());
    const auto again = config::load_text<CameraConfig>("printed", config::to_yaml(loaded));
    EXPECT_EQ(config::to_yaml(again), config::to_yaml(loaded)) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 2);
}

// Live.

constexpr char kLeftAddress[] = "10.88.0.1";
constexpr char kRightAddress[] = "10.88.0.2";

std::string network_fault() {
  static const std::string fault = [] {
    std::string reason = enter_private_network();
    if (reason.empty()) reason = add_loopback_address(1, kLeftAddress);
    if (reason.empty()) reason = add_loopback_address(2, kRightAddress);
    return reason;
  }();
  return fault;
}

std::string url() {
  return "udpm://239.255.76.67:" + std::to_string(private_port()) + "?ttl=0&recv_buf_size=4194304";
}

/// A scene whose light is `per_ms` grey levels for a millisecond of exposure, and which both cameras see at one moment:
/// the moment's number is in the corner of both images.
camera::GvServer::Render scene(int side, const std::atomic<double>& per_ms, std::int64_t period_us) {
  return [side, &per_ms, period_us](const camera::GvServer::Request& r) {
    const double level = std::min(255.0, per_ms * r.exposure_us * 1e-3);
    cv::Mat1b image(r.size_px, static_cast<std::uint8_t>(level));
    const std::int64_t moment = to_utime(r.device_time) / period_us;  // frames come at or after its multiples
    image(0, 0) = static_cast<std::uint8_t>(moment & 0xFF);
    image(0, 1) = static_cast<std::uint8_t>(side);
    const std::int64_t device_us = to_utime(r.device_time);
    std::memcpy(image.ptr(1), &device_us, sizeof device_us);
    return image;
  };
}

class CameraProcessLive : public testing::Test {
 protected:
  static constexpr double kRateHz = 25;
  static constexpr std::int64_t kPeriodUs = 40'000;

  void SetUp() override {
    if (!network_fault().empty()) GTEST_SKIP() << "no private network: " << network_fault();
    config_.left_device = kLeftAddress;
    config_.right_device = kRightAddress;
    config_.width_px = 160;
    config_.height_px = 128;
    config_.rate_hz = kRateHz;
    config_.connection = {0.1, 0.5, 0.4};
    config_.exposure.mode = "fixed";
    listener_ = std::make_unique<LcmBus>(url());
    subscribe<stereo_images_t>(*listener_, channels::kStereoImages, {},
                               [this](const stereo_images_t& pair) { pairs_.push_back(pair); });
    listener_->start();
  }
  void plug(int side) {
    servers_[side] = std::make_unique<camera::GvServer>(side == 0 ? kLeftAddress : kRightAddress, side == 0 ? "L" : "R",
                                                        scene(side, per_ms_, kPeriodUs));
  }
  void start() {
    bus_ = std::make_unique<LcmBus>(url());
    process_ = std::make_unique<CameraProcess>(config_, *bus_, *bus_);
    bus_->start();
  }
  /// Runs process and listener until `done`, at most `limit`.
  template <class Done>
  bool run(Done done, std::chrono::milliseconds limit = 6s) {
    const auto until = Steady::now() + limit;
    while (!done()) {
      if (Steady::now() > until) return false;
      bus_->run_for(2ms);
      listener_->run_for(1ms);
    }
    return true;
  }
  bool run_pairs(std::size_t count) {
    pairs_.clear();
    return run([&] { return pairs_.size() >= count; });
  }
  void expect_true_pairs() {
    for (const auto& pair : pairs_) {
      const cv::Mat1b left = image_of(pair.left);
      const cv::Mat1b right = image_of(pair.right);
      ASSERT_EQ(left(0, 0), right(0, 0)) << "images of one moment";
      ASSERT_EQ(left(0, 1), 0);
      ASSERT_EQ(right(0, 1), 1);
    }
  }
  static std::int64_t device_us(const stereo_images_t& pair) {
    std::int64_t us = 0;
    std::memcpy(&us, image_of(pair.left).ptr(1), sizeof us);
    return us;
  }
  void end() {
    const auto begin = Steady::now();
    process_->finish();
    process_.reset();
    EXPECT_LT(Steady::now() - begin, 1500ms) << "nothing blocks the end";
  }
  bool said(const std::string& words) const {
    for (const auto& [message, count] : bus_->health().messages()) {
      if (message.find(words) != std::string::npos) return true;
    }
    return false;
  }

  CameraConfig config_;
  std::atomic<double> per_ms_{30};
  std::unique_ptr<camera::GvServer> servers_[2];
  std::unique_ptr<LcmBus> listener_;
  std::unique_ptr<LcmBus> bus_;
  std::unique_ptr<CameraProcess> process_;
  std::vector<stereo_images_t> pairs_;
};

TEST_F(CameraProcessLive, TwoCamerasGivePairsOfOneMomentStampedAsTheyWereTaken) {
  plug(0), plug(1);
  start();
  ASSERT_TRUE(run_pairs(25));
  expect_true_pairs();
  for (std::size_t i = 1; i < pairs_.size(); ++i) {
    EXPECT_GE(pairs_[i].sequence, pairs_[i - 1].sequence + 1);
  }
  for (const stereo_images_t& pair : pairs_) {
    // The served cameras' clock is this machine's, like the bus': so the stamp's own error shows. (They do not wait for
    // the exposure to pass, as the driver must believe.)
    EXPECT_NEAR(double(pair.utime - 1500 - device_us(pair)), 0, 15'000);
  }
  EXPECT_EQ(pairs_.back().exposure_us, 3000);
  // Stamps lie a little in the past: the middle of an exposure that is over.
  EXPECT_LT(pairs_.back().utime, to_utime(bus_->now()));
  EXPECT_GT(pairs_.back().utime, to_utime(bus_->now()) - 1'000'000);
  end();
}

TEST_F(CameraProcessLive, OneExposureForBothFollowsTheLight) {
  config_.exposure.mode = "auto";
  config_.exposure.max_gain_db = 0;  // the served camera counts its gain in units of its own
  plug(0), plug(1);
  start();
  const auto settles_at = [&](int exposure_us) {
    return run([&] { return !pairs_.empty() && std::abs(pairs_.back().exposure_us - exposure_us) < exposure_us / 5; });
  };
  EXPECT_TRUE(settles_at(3000)) << "30 levels a millisecond: 90 wanted";
  per_ms_ = 120;
  EXPECT_TRUE(settles_at(750));
  per_ms_ = 20;
  EXPECT_TRUE(settles_at(4500));
  end();
}

TEST_F(CameraProcessLive, ACameraThatIsMissingIsSaidAndFoundWhenItComes) {
  plug(0);
  start();
  EXPECT_FALSE(run([&] { return !pairs_.empty(); }, 800ms));
  EXPECT_TRUE(said("right camera: no GigE Vision camera answers at 10.88.0.2"));
  plug(1);
  EXPECT_TRUE(run_pairs(5));
  expect_true_pairs();
  end();
}

TEST_F(CameraProcessLive, AUnpluggedCameraIsNoticedWithinASecondAndTakenBackWithinThree) {
  plug(0), plug(1);
  start();
  ASSERT_TRUE(run_pairs(5));
  const std::int64_t before = pairs_.back().sequence;
  servers_[0].reset();
  EXPECT_TRUE(run([&] { return said("left camera: it does not answer any more"); }, 2s));
  EXPECT_TRUE(run([&] { return bus_->health().counter(channels::kStereoImages, "unpaired_right") > 0; }, 2s));
  plug(0);
  pairs_.clear();
  EXPECT_TRUE(run([&] { return pairs_.size() >= 5; }, 3s));
  expect_true_pairs();
  EXPECT_GT(pairs_.front().sequence, before);
  EXPECT_EQ(bus_->health().counter(channels::kStereoImages, "reopened_left"), 1);
  end();
}

TEST_F(CameraProcessLive, WithoutAnyCameraItEndsAtOnceWhenAsked) {
  start();
  run([] { return false; }, 300ms);
  end();
}

}  // namespace
}  // namespace arpent
