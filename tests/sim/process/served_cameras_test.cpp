// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Hardware in the loop for the cameras: what the simulator sees is served by two GigE Vision cameras on loopback, and
// camera_process makes pairs of it again, over GVCP, GVSP and Aravis, as it would of the robot's. Every pair is, byte
// for byte, one that was rendered.
#include <gtest/gtest.h>

#include <arpent/stereo_images_t.hpp>
#include <chrono>
#include <map>
#include <mutex>

#include "common/bus/lcm_bus.h"
#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/net/private_network.h"
#include "drivers/base/process/base_driver_process.h"
#include "drivers/base/wire.h"
#include "drivers/camera/gv_server.h"
#include "drivers/camera/process/camera_process.h"
#include "perception/stereo/wire.h"
#include "sim/camera/renderer.h"
#include "sim/process/sim_process.h"

namespace arpent {
namespace {

using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;
using camera::GvServer;

constexpr const char* kAddresses[] = {"10.88.0.1", "10.88.0.2"};
constexpr double kRateHz = 5;
constexpr std::int64_t kPeriodUs = 200'000;
constexpr char kRobot[] = ARPENT_SOURCE_DIR "/config/robots/wifibot.yaml";
constexpr char kWorld[] = ARPENT_SOURCE_DIR "/config/worlds/test_arena.yaml";

std::string network_fault() {
  static const std::string fault = [] {
    std::string reason = enter_private_network();
    if (reason.empty()) reason = add_loopback_address(1, kAddresses[0]);
    if (reason.empty()) reason = add_loopback_address(2, kAddresses[1]);
    return reason;
  }();
  return fault;
}

bool same(const cv::Mat1b& a, const cv::Mat1b& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

/// What sim_process publishes while the robot turns on the spot: no two images are alike.
std::vector<stereo::StereoPair> simulated_pairs(std::size_t count) {
  LockstepExecutor executor{Time(100s)};
  std::vector<stereo::StereoPair> pairs;
  executor.set_tap([&](Time, const std::string& channel, BytesView bytes) {
    if (channel != channels::kStereoImages) return;
    stereo_images_t message;
    std::string fault;
    ASSERT_TRUE(decode_guarded(bytes, message, fault)) << fault;
    pairs.push_back(*stereo::from_wire(message));
  });
  SimConfig sim_config;
  sim_config.world = kWorld;
  sim_config.robot = kRobot;
  const auto sim_end = executor.add_process(SimProcess::kName);
  const SimProcess sim(sim_config, sim_end.bus, sim_end.clock);
  const auto base_end = executor.add_process(BaseDriverProcess::kName);
  const BaseDriverProcess base({.robot = kRobot, .port = "bus", .can_log = {}, .dry_run = false}, base_end.bus,
                               base_end.clock);
  executor.inject(Time(100s) + 400ms, channels::kBaseRequest,
                  encode(base::to_wire({executor.now(), base::Action::kArm, "test"})));
  executor.run_until(Time(100s) + 500ms);
  while (pairs.size() < count) {
    executor.inject(executor.now(), channels::kWheelCommand, encode(base::to_wire({executor.now(), {0, 0.8}})));
    executor.run_until(executor.now() + 100ms);
  }
  return pairs;
}

class ServedCameras : public testing::Test {
 protected:
  void SetUp() override {
    if (!network_fault().empty()) GTEST_SKIP() << "no private network: " << network_fault();
    config_.left_device = kAddresses[0];
    config_.right_device = kAddresses[1];
    config_.rate_hz = kRateHz;
    config_.exposure.mode = "fixed";
    config_.pairing.clocks = "shared";
    config_.pairing.tolerance_s = 0.03;  // the servers keep time as well as this machine lets them
  }
  void start(const GvServer::Render& left, const GvServer::Render& right) {
    servers_[0] = std::make_unique<GvServer>(kAddresses[0], "L", left);
    servers_[1] = std::make_unique<GvServer>(kAddresses[1], "R", right);
    listener_ = std::make_unique<LcmBus>(url());
    subscribe<stereo_images_t>(*listener_, channels::kStereoImages, {}, [this](const stereo_images_t& message) {
      pairs_.push_back(*stereo::from_wire(message));
      exposures_us_.push_back(message.exposure_us);
    });
    listener_->start();
    bus_ = std::make_unique<LcmBus>(url());
    process_ = std::make_unique<CameraProcess>(config_, *bus_, *bus_);
    bus_->start();
  }
  void unplug() { servers_[0].reset(), servers_[1].reset(); }
  bool run_until(const std::function<bool()>& done) {
    const auto until = Steady::now() + 50s;
    while (!done()) {
      if (Steady::now() > until) return false;
      bus_->run_for(2ms);
      listener_->run_for(1ms);
    }
    return true;
  }
  static std::string url() {
    return "udpm://239.255.76.67:" + std::to_string(private_port()) + "?ttl=0&recv_buf_size=4194304";
  }
  /// The nearest multiple of the period: the first frames may still keep the rate from before the driver set its own.
  static std::int64_t moment_of(const GvServer::Request& request) {
    return (to_utime(request.device_time) + kPeriodUs / 2) / kPeriodUs;
  }

  CameraConfig config_;
  std::unique_ptr<GvServer> servers_[2];
  std::unique_ptr<LcmBus> listener_, bus_;
  std::unique_ptr<CameraProcess> process_;
  std::vector<stereo::StereoPair> pairs_;
  std::vector<int> exposures_us_;
};

TEST_F(ServedCameras, ThePairsOfTheSimulatorComeBackByteForByte) {
  // shared: the servers' threads read it as long as they are there
  const auto shared = std::make_shared<const std::vector<stereo::StereoPair>>(simulated_pairs(24));
  const auto& rendered = *shared;
  const auto serve = [shared](bool left) -> GvServer::Render {
    return [shared, left](const GvServer::Request& request) {
      const auto& pair = (*shared)[static_cast<std::size_t>(moment_of(request)) % shared->size()];
      return left ? pair.left : pair.right;
    };
  };
  start(serve(true), serve(false));
  ASSERT_TRUE(run_until([this] { return pairs_.size() >= 12; }));
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const auto found = std::find_if(rendered.begin(), rendered.end(),
                                    [&](const stereo::StereoPair& r) { return same(r.left, pairs_[i].left); });
    ASSERT_NE(found, rendered.end()) << "the left image of pair " << i << " was not rendered like this";
    EXPECT_TRUE(same(found->right, pairs_[i].right)) << "the right image of pair " << i << " is of another moment";
    if (i > 0) {
      EXPECT_GT(pairs_[i].sequence, pairs_[i - 1].sequence);
    }
  }
  EXPECT_FALSE(same(pairs_[5].left, pairs_[10].left)) << "the robot was turning";
}

/// The cameras look into the world themselves, with the exposure that the driver sets.
TEST_F(ServedCameras, TheDriversExposureIsTheRenderersAndTravelsWithThePair) {
  config_.exposure.mode = "auto";
  config_.exposure.exposure_us = 400;  // much too dark
  config_.exposure.max_gain_db = 0;    // the served camera counts its gain in a unit of its own
  const sim::Renderer renderer(sim::load_world(kWorld));
  auto rig_config = config::load<RigConfig>(ARPENT_SOURCE_DIR "/config/rigs/wifibot_stereo.yaml");
  // Small ones, rendered in time on slow machines too.
  for (RigCamera* camera : {&rig_config.left, &rig_config.right})
    *camera = {160, 128, 94.25, 94.25, 79.5, 63.5, "none", {}};
  config_.width_px = 160;
  config_.height_px = 128;
  const StereoCalibration rig = to_calibration(rig_config, "rig");
  const sim::CameraModel models[] = {sim::CameraModel(rig.left), sim::CameraModel(rig.right)};
  const Pose T_world_left = sim::start_of(sim::load_world(kWorld), 0).to_pose() * rig.T_body_left;
  const Pose T_world_cams[] = {T_world_left, T_world_left * rig.T_right_left.inverse()};
  struct Sent {
    cv::Mat1b image;
    int exposure_us;
  };
  std::multimap<std::int64_t, Sent> sent[2];  // by moment; the first frames may share one
  std::mutex mutex;
  const auto serve = [&](std::size_t side) -> GvServer::Render {
    return [&, side](const GvServer::Request& request) {
      sim::CameraShot shot;
      shot.exposure_s = 1e-6 * request.exposure_us;
      shot.seed = static_cast<std::uint64_t>(2 * moment_of(request)) + side;
      const cv::Mat1b image = renderer.render(models[side], T_world_cams[side], shot).image;
      const std::lock_guard lock(mutex);
      sent[side].insert({moment_of(request), {image, request.exposure_us}});
      return image;
    };
  };
  start(serve(0), serve(1));
  const auto level = [](const cv::Mat1b& image) { return cv::mean(image)[0]; };
  const double wanted = config_.exposure.target_level;
  const bool settles =
      run_until([&] { return pairs_.size() >= 5 && std::abs(level(pairs_.back().left) - wanted) < 0.15 * wanted; });
  const std::size_t settled_at = pairs_.size();
  const bool goes_on = run_until([&] { return pairs_.size() >= settled_at + 5; });
  unplug();  // their threads look at what stands above
  ASSERT_TRUE(settles && goes_on);
  EXPECT_LT(level(pairs_.front().left), 0.7 * wanted);
  int settled = 0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const auto found = std::find_if(sent[0].begin(), sent[0].end(),
                                    [&](const auto& s) { return same(s.second.image, pairs_[i].left); });
    ASSERT_NE(found, sent[0].end()) << "the left image of pair " << i << " was not rendered like this";
    const auto [begin, end] = sent[1].equal_range(found->first);
    const auto right = std::find_if(begin, end, [&](const auto& s) { return same(s.second.image, pairs_[i].right); });
    ASSERT_NE(right, end) << "the right image of pair " << i << " is of another moment";
    // While a setting is on its way, the two cameras may take it a frame apart, and the driver counts such a pair.
    if (found->second.exposure_us != right->second.exposure_us) continue;
    settled += exposures_us_[i] == found->second.exposure_us ? 1 : 0;
  }
  EXPECT_GE(settled, 3);
  EXPECT_EQ(exposures_us_.front(), 400);
}

}  // namespace
}  // namespace arpent
