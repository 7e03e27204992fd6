// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// imu_process on the in-memory bus, with a device of files.
#include "drivers/imu/process/imu_process.h"

#include <gtest/gtest.h>

#include <arpent/imu_t.hpp>
#include <cmath>
#include <limits>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "drivers/imu/wire.h"
#include "tests/drivers/imu/fake_iio.h"

namespace arpent {
namespace {

using namespace std::chrono_literals;

class ImuProcessTest : public testing::Test {
 protected:
  ImuProcessTest() {
    config_.iio.device = "bmi160";
    executor_.set_tap([this](Time, const std::string& channel, BytesView bytes) {
      EXPECT_EQ(channel, channels::kImu);
      std::string fault;
      messages_.emplace_back();
      EXPECT_TRUE(decode_guarded(bytes, messages_.back(), fault)) << fault;
    });
  }
  void plug() {
    fake_ = std::make_unique<imu::FakeIio>(root_);
    config_.iio.sysfs = fake_->sysfs();
    config_.iio.dev = fake_->dev();
  }
  void start() {
    const auto [bus, clock] = executor_.add_process("imu_process");
    health_ = &bus.health();
    process_ = std::make_unique<ImuProcess>(config_, bus, clock);
  }
  void run(Duration duration) { executor_.run_until(executor_.now() + duration); }

  std::filesystem::path root_ = std::filesystem::path(testing::TempDir()) /
                                (std::string("imu_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  ImuConfig config_;
  LockstepExecutor executor_{Time(100s)};
  std::unique_ptr<imu::FakeIio> fake_;
  std::unique_ptr<ImuProcess> process_;
  Health* health_ = nullptr;
  std::vector<imu_t> messages_;
};

TEST_F(ImuProcessTest, ReadingsAreTurnedIntoBodyAxes) {
  const double half = std::sqrt(0.5);
  config_.mount_quaternion_wxyz = {half, 0, 0, half};  // the sensor's x is the body's y (left)
  plug();
  start();
  run(10ms);
  fake_->send({100, 0, 7, 0, 200, 981}, 1'000'000'000);
  run(10ms);
  ASSERT_EQ(messages_.size(), 1U);
  const double expected_rate[] = {0, 0.1, 0.007};
  const double expected_acceleration[] = {-2, 1, 9.81};  // x of the sensor reads (0 + 100) * 0.01
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(messages_[0].angular_velocity_radps[i], expected_rate[i], 1e-12) << i;
    EXPECT_NEAR(messages_[0].acceleration_mps2[i], expected_acceleration[i], 1e-12) << i;
  }
}

TEST_F(ImuProcessTest, LostReadingsAreGapsInTheSequence) {
  plug();
  start();
  run(10ms);
  fake_->send({}, 1'000'000'000);
  fake_->send({}, 1'005'000'000);
  fake_->send({}, 1'020'000'000);
  fake_->send({}, 1'020'000'000);
  run(10ms);
  ASSERT_EQ(messages_.size(), 3U);
  EXPECT_EQ(messages_[1].sequence, 1);
  EXPECT_EQ(messages_[2].sequence, 4);
  EXPECT_EQ(messages_[2].utime - messages_[0].utime, 20000);
  EXPECT_EQ(health_->counter(channels::kImu, "lost"), 2);
  EXPECT_EQ(health_->counter(channels::kImu, "not_later"), 1);
}

TEST_F(ImuProcessTest, AMissingUnitIsSaidAndFoundWhenItComes) {
  config_.iio.sysfs = root_ / "devices";
  config_.iio.dev = root_ / "dev";
  start();
  run(1500ms);
  const auto condition = health_->take_condition();
  EXPECT_EQ(condition.level, Health::Level::kError);
  EXPECT_NE(condition.message.find("no IIO device bmi160"), std::string::npos) << condition.message;
  plug();
  run(800ms);
  EXPECT_EQ(health_->counter(channels::kImu, "opened"), 1);
  fake_->send({}, 1'000'000'000);
  run(10ms);
  EXPECT_EQ(messages_.size(), 1U);
}

TEST_F(ImuProcessTest, ASilentUnitIsOpenedAnew) {
  plug();
  start();
  run(700ms);
  EXPECT_NE(health_->take_condition().message.find("sends nothing"), std::string::npos);
  run(2s);
  EXPECT_GE(health_->counter(channels::kImu, "opened"), 2);
  process_->finish();
  EXPECT_EQ(fake_->text("buffer/enable"), "0");
}

TEST_F(ImuProcessTest, AMountingThatIsNoRotationIsRefused) {
  config_.mount_quaternion_wxyz = {1, 1, 0, 0};
  EXPECT_THROW(start(), InputError);
}

TEST(ImuWire, EveryFieldArrivesWhereItBelongs) {
  const imu::Reading sent{Time(Duration(42)), {1, 2, 3}, {4, 5, 6}};
  const imu_t message = imu::to_wire(sent, 7);
  EXPECT_EQ(message.sequence, 7);
  const auto received = imu::from_wire(message);
  ASSERT_TRUE(received) << received.fault();
  EXPECT_EQ(received->stamp, sent.stamp);
  EXPECT_EQ(received->angular_velocity_radps, sent.angular_velocity_radps);
  EXPECT_EQ(received->acceleration_mps2, sent.acceleration_mps2);
}

TEST(ImuWire, WhatIsNotFiniteIsRefused) {
  imu_t message = imu::to_wire({Time(), {1, 2, 3}, {4, 5, 6}}, 0);
  message.angular_velocity_radps[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(imu::from_wire(message));
  message = imu::to_wire({Time(), {1, 2, 3}, {4, 5, 6}}, 0);
  message.acceleration_mps2[2] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(imu::from_wire(message));
  EXPECT_FALSE(imu::from_wire(imu::to_wire({Time(), {1, 2, 3}, {4, 5, 6}}, -1)));
}

}  // namespace
}  // namespace arpent
