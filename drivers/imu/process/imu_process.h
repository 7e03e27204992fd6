// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// imu_process: an inertial unit of the kernel in, IMU out, in body axes. A unit that is missing, taken away or silent
// is a health error, and is looked for again.
#pragma once

#include <memory>
#include <vector>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "drivers/imu/iio_imu.h"

namespace arpent {

struct ImuConfig {
  imu::IioParams iio;
  std::vector<double> mount_quaternion_wxyz{1, 0, 0, 0};
  double silence_s = 0.5;
  double retry_s = 1;
  int poll_us = 5000;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.group("iio", self.iio, "the device");
    visitor.field("mount_quaternion_wxyz", self.mount_quaternion_wxyz,
                  "rotation from the sensor's axes to the body's (x forward, y left, z up), scalar first",
                  config::finite_numbers(4));
    visitor.field("silence_s", self.silence_s, "a device that sends nothing for so long is opened anew",
                  config::between(0.05, 60.0));
    visitor.field("retry_s", self.retry_s, "wait between attempts to open it", config::between(0.05, 60.0));
    visitor.field("poll_us", self.poll_us, "time between two looks at the device", config::between(500, 1000000));
  }
};

class ImuProcess {
 public:
  using Config = ImuConfig;
  static constexpr char kName[] = "imu_process";
  static constexpr char kHelp[] = "Publishes the readings of an inertial unit in body axes.";

  /// Throws InputError if the mounting is no rotation. A unit that is not there is no error.
  ImuProcess(const Config& config, Bus& bus, Clock& clock);
  ~ImuProcess();

  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
