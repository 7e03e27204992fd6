// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// GenICam cameras without hardware: Aravis' built-in camera in this process, and GigE Vision cameras that we serve over
// loopback, in a network of our own.
#include "drivers/camera/aravis_source.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "common/net/private_network.h"
#include "drivers/camera/frame_counter.h"
#include "drivers/camera/gv_server.h"
#include "drivers/camera/gvcp_probe.h"

namespace arpent::camera {
namespace {

using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;

constexpr char kLeftAddress[] = "10.88.0.1";
constexpr ImageFormat kFormat{160, 128, 50};
constexpr ExposureSetting kExposure{2000, 0};

/// Why there can be no private network here; empty if we are in it, with an address for a camera.
std::string network_fault() {
  static const std::string fault = [] {
    const std::string reason = enter_private_network();
    return reason.empty() ? add_loopback_address(1, kLeftAddress) : reason;
  }();
  return fault;
}

HostTime host() {
  return HostTime(Time(1s));
}

std::vector<Frame> read(FrameSource& source, std::size_t count) {
  std::vector<Frame> frames;
  const auto limit = Steady::now() + 5s;
  while (frames.size() < count && Steady::now() < limit) {
    if (auto frame = source.next(100ms)) frames.push_back(std::move(*frame));
  }
  return frames;
}

cv::Mat1b ramp(cv::Size size, int start) {
  cv::Mat1b image(size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) image(y, x) = static_cast<std::uint8_t>(start + x + 3 * y);
  }
  return image;
}

TEST(AravisFakeCamera, DeliversFramesOfTheWantedSizeWithRisingIdsAndTimes) {
  enable_fake_camera();
  const auto source = open_aravis({"Fake_1", ""}, {}, kFormat, kExposure, host());
  const auto frames = read(*source, 5);
  ASSERT_EQ(frames.size(), 5U);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].image.size(), cv::Size(160, 128));
    EXPECT_EQ(frames[i].exposure_us, 2000);
    if (i == 0) continue;
    EXPECT_EQ(frames[i].frame_id, frames[i - 1].frame_id + 1);
    EXPECT_GT(frames[i].device_time, frames[i - 1].device_time);
    EXPECT_GE(frames[i].arrival, frames[i - 1].arrival);
  }
  EXPECT_TRUE(source->answers());
}

TEST(AravisFakeCamera, IsListedOnlyWhenAskedFor) {
  const auto names = [](const std::vector<AravisListing>& listing) {
    std::vector<std::string> result;
    for (const auto& l : listing) result.push_back(l.name);
    return result;
  };
  const auto with = names(list_aravis(true));
  EXPECT_NE(std::find(with.begin(), with.end(), "Fake_1"), with.end());
}

TEST(AravisFakeCamera, ATriggerOrAFeatureThatItDoesNotHaveIsOneClearFault) {
  enable_fake_camera();
  AravisParams params;
  params.trigger = "Line77";
  try {
    (void)open_aravis({"Fake_1", ""}, params, kFormat, kExposure, host());
    FAIL() << "opened";
  } catch (const DeviceLost& lost) {
    EXPECT_NE(std::string(lost.what()).find("Line77"), std::string::npos) << lost.what();
  }
  EXPECT_THROW((void)open_aravis({"Fake_1", "NoSuchFeature=1"}, {}, kFormat, kExposure, host()), DeviceLost);
  EXPECT_THROW((void)open_aravis({"Fake_1", ""}, {}, {5000, 5000, 50}, kExposure, host()), DeviceLost);
}

class GigeCamera : public testing::Test {
 protected:
  void SetUp() override {
    if (!network_fault().empty()) GTEST_SKIP() << "no private network: " << network_fault();
  }
};

TEST_F(GigeCamera, ImagesCrossTheNetworkByteForByte) {
  const GvServer server(kLeftAddress, "L1", [](const GvServer::Request& r) { return ramp(r.size_px, 7); });
  EXPECT_TRUE(gige_camera_answers(kLeftAddress, 500ms));
  const auto source = open_aravis({kLeftAddress, ""}, {}, kFormat, kExposure, host());
  const auto frames = read(*source, 3);
  ASSERT_EQ(frames.size(), 3U);
  for (const Frame& frame : frames) {
    EXPECT_EQ(cv::norm(frame.image, ramp(kFormat.width_px > 0 ? cv::Size(160, 128) : cv::Size(), 7), cv::NORM_INF), 0);
    EXPECT_EQ(frame.id_period, 65535);
  }
}

TEST_F(GigeCamera, TheFrameCounterCrossesItsWrapWithoutAGap) {
  const GvServer server(kLeftAddress, "L1", [](const GvServer::Request& r) { return ramp(r.size_px, 1); });
  const auto source = open_aravis({kLeftAddress, ""}, {}, {64, 64, 200}, kExposure, host());
  const auto frames = read(*source, 150);  // its ids begin at 65401
  ASSERT_EQ(frames.size(), 150U);
  FrameCounter counter;
  std::int64_t missed = 0;
  for (const Frame& frame : frames) {
    const auto reading = counter.read(frame.frame_id, frame.id_period);
    EXPECT_EQ(reading.step, FrameCounter::Step::kForward);
    missed += reading.missed;
  }
  EXPECT_LT(frames.back().frame_id, frames.front().frame_id) << "it wrapped";
  EXPECT_EQ(missed, source->incomplete());
}

TEST_F(GigeCamera, ExposureAndGainReachTheDeviceAndTravelWithTheFrames) {
  std::atomic<int> exposure_us{0};
  const GvServer server(kLeftAddress, "L1", [&](const GvServer::Request& r) {
    exposure_us = r.exposure_us;
    return cv::Mat1b(r.size_px, static_cast<std::uint8_t>(r.exposure_us / 100));
  });
  const auto source = open_aravis({kLeftAddress, ""}, {}, kFormat, kExposure, host());
  EXPECT_EQ(read(*source, 2).back().exposure_us, 2000);
  source->set_exposure({4000, 3});
  (void)read(*source, 2);  // one may have been under way
  const Frame frame = read(*source, 1).back();
  EXPECT_EQ(frame.exposure_us, 4000);
  EXPECT_EQ(frame.gain_db, 3);
  EXPECT_EQ(exposure_us, 4000);
  EXPECT_EQ(frame.image(0, 0), 40);
}

TEST_F(GigeCamera, AnAddressWhereNoCameraIsIsRefusedAtOnce) {
  const auto start = Steady::now();
  EXPECT_THROW((void)open_aravis({kLeftAddress, ""}, {}, kFormat, kExposure, host()), DeviceLost);
  EXPECT_LT(Steady::now() - start, 1s);
}

TEST_F(GigeCamera, AnUnpluggedCameraIsSilentAndDoesNotAnswer) {
  auto server = std::make_unique<GvServer>(kLeftAddress, "L1", [](const auto& r) { return ramp(r.size_px, 1); });
  const auto source = open_aravis({kLeftAddress, ""}, {}, kFormat, kExposure, host());
  ASSERT_FALSE(read(*source, 1).empty());
  EXPECT_TRUE(source->answers());
  server.reset();
  while (source->next(100ms)) {
  }
  EXPECT_FALSE(source->answers());
}

TEST_F(GigeCamera, AnAddressThatIsNotOursCannotServe) {
  EXPECT_THROW(GvServer("10.99.99.99", "X", [](const auto& r) { return ramp(r.size_px, 1); }), std::exception);
}

}  // namespace
}  // namespace arpent::camera
