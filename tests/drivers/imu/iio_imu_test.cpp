// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/iio_imu.h"

#include <gtest/gtest.h>

#include "tests/drivers/imu/fake_iio.h"

namespace arpent::imu {
namespace {

using namespace std::chrono_literals;

class ImuIio : public testing::Test {
 protected:
  ImuIio() {
    params_.device = "iio:device0";
    params_.sysfs = fake_.sysfs();
    params_.dev = fake_.dev();
  }
  std::string fault() {
    try {
      const IioImu imu(params_, host_);
    } catch (const ImuLost& lost) {
      return lost.what();
    }
    return "";
  }

  FakeIio fake_{std::filesystem::path(testing::TempDir()) /
                (std::string("iio_") + testing::UnitTest::GetInstance()->current_test_info()->name())};
  IioParams params_;
  HostTime host_{Time(5000s)};
};

TEST_F(ImuIio, ReadingsAreScaledAndStampedInTheBusTime) {
  IioImu imu(params_, host_);
  EXPECT_TRUE(imu.read().empty());
  fake_.send({1, -2, 3, 400, -500, 981}, 7'000'000'000);
  fake_.send({4, 5, 6, 7, 8, 9}, 7'005'000'000);
  const auto readings = imu.read();
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_TRUE(readings[0].angular_velocity_radps.isApprox(Eigen::Vector3d(0.001, -0.002, 0.003)));
  EXPECT_TRUE(readings[0].acceleration_mps2.isApprox(Eigen::Vector3d((400 + 100) * 0.01, -5, 9.81)));
  EXPECT_EQ(readings[0].stamp, host_.from_monotonic(7s));
  EXPECT_EQ(readings[1].stamp - readings[0].stamp, 5ms);
}

TEST_F(ImuIio, TheDeviceIsSetUpThroughSysfsAndSwitchedOffAtTheEnd) {
  params_.buffer_readings = 32;
  params_.trigger = "sysfstrig1";
  {
    const IioImu imu(params_, host_);
    EXPECT_EQ(fake_.text("current_timestamp_clock"), "monotonic");
    EXPECT_EQ(fake_.text("sampling_frequency"), "200");
    EXPECT_EQ(fake_.text("scan_elements/in_accel_z_en"), "1");
    EXPECT_EQ(fake_.text("scan_elements/in_timestamp_en"), "1");
    EXPECT_EQ(fake_.text("scan_elements/in_temp_en"), "0") << "an unknown channel would shift the rest";
    EXPECT_EQ(fake_.text("buffer/length"), "32");
    EXPECT_EQ(fake_.text("buffer/enable"), "1");
    EXPECT_EQ(fake_.text("trigger/current_trigger"), "sysfstrig1");
    EXPECT_EQ(imu.rate_hz(), 200);
  }
  EXPECT_EQ(fake_.text("buffer/enable"), "0");
}

TEST_F(ImuIio, AScanThatArrivesInPiecesIsPutTogether) {
  IioImu imu(params_, host_);
  fake_.send_bytes(std::string(10, '\1'));
  EXPECT_TRUE(imu.read().empty());
  fake_.send_bytes(std::string(14 + 24, '\1'));
  EXPECT_EQ(imu.read().size(), 2U);
}

TEST_F(ImuIio, KernelsWithoutAChoiceOfClockStampInRealTime) {
  std::filesystem::remove(fake_.device() / "current_timestamp_clock");
  IioImu imu(params_, host_);
  fake_.send({}, 9'000'000'000);
  EXPECT_EQ(imu.read().at(0).stamp, host_.from_realtime(9s));
}

TEST_F(ImuIio, IsFoundByItsName) {
  params_.device = "bmi160";
  EXPECT_EQ(fault(), "");
  params_.device = "mpu6050";
  EXPECT_NE(fault().find("mpu6050"), std::string::npos);
}

TEST_F(ImuIio, WhatIsMissingOrWrongIsNamed) {
  std::filesystem::remove(fake_.device() / "scan_elements/in_accel_y_type");
  EXPECT_NE(fault().find("in_accel_y"), std::string::npos) << fault();
  fake_.write("scan_elements/in_accel_y_type", "le:f32/32>>0");
  EXPECT_NE(fault().find("le:f32"), std::string::npos) << fault();
  fake_.write("scan_elements/in_accel_y_type", "le:s16/16>>0");
  fake_.write("in_anglvel_scale", "fast");
  EXPECT_NE(fault().find("in_anglvel_scale"), std::string::npos) << fault();
  fake_.write("in_anglvel_scale", "1");
  std::filesystem::remove(fake_.chardev());
  EXPECT_NE(fault().find("opening"), std::string::npos) << fault();
}

TEST(ImuReadingCounter, LostReadingsAreGapsAndJitterIsNot) {
  ReadingCounter counter(200);
  const auto at = [](std::int64_t us) { return Time(Duration(us)); };
  EXPECT_EQ(counter.number(at(0)), 0);
  EXPECT_EQ(counter.number(at(5300)), 1);
  EXPECT_EQ(counter.number(at(9000)), 2);
  EXPECT_EQ(counter.number(at(24100)), 5) << "15.1 ms are three periods";
  EXPECT_EQ(counter.number(at(24100)), std::nullopt);
  EXPECT_EQ(counter.number(at(20000)), std::nullopt);
  EXPECT_EQ(counter.number(at(26000)), 6) << "early, but another one";
}

}  // namespace
}  // namespace arpent::imu
