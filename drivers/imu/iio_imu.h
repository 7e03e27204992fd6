// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// An inertial unit of Linux' Industrial I/O: set up through sysfs, read from its character device. Gyroscope and
// accelerometer must be channels of one device, so that each sample has one time.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/config/fields.h"
#include "common/host_time.h"
#include "drivers/imu/iio_scan.h"

namespace arpent::imu {

struct Reading {
  Time stamp;
  Eigen::Vector3d angular_velocity_radps;  ///< in the axes of the sensor, or the body's once turned
  Eigen::Vector3d acceleration_mps2;       ///< specific force
};

/// The device is not there, refuses, or was taken away: try again later.
class ImuLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct IioParams {
  std::string device;
  double rate_hz = 200;
  int buffer_readings = 64;
  std::string trigger;
  std::filesystem::path sysfs = "/sys/bus/iio/devices";
  std::filesystem::path dev = "/dev";

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("device", self.device, "folder (iio:device0) or name (e.g. bmi160) of the device",
                  config::required_text());
    visitor.field("rate_hz", self.rate_hz, "readings per second", config::between(1.0, 10000.0));
    visitor.field("buffer_readings", self.buffer_readings, "readings that may wait in the kernel",
                  config::between(2, 100000));
    visitor.field("trigger", self.trigger, "IIO trigger to use; empty: the device's own");
    visitor.field("sysfs", self.sysfs, "where the kernel describes its devices");
    visitor.field("dev", self.dev, "where the character devices are");
  }
};

class IioImu {
 public:
  /// Sets the device up and starts it. Throws ImuLost.
  IioImu(const IioParams& params, const HostTime& host);
  ~IioImu();
  IioImu(const IioImu&) = delete;
  IioImu& operator=(const IioImu&) = delete;

  /// The readings that have arrived, in order; never waits. Throws ImuLost.
  [[nodiscard]] std::vector<Reading> read();
  /// What the device says that it samples at; rate_hz if it does not say.
  [[nodiscard]] double rate_hz() const { return rate_hz_; }

 private:
  struct Axis {
    ScanChannel channel;
    double scale = 1;   ///< to rad/s or m/s^2
    double offset = 0;  ///< added to the raw value before it is scaled
  };
  void choose_clock();
  void choose_rate(const IioParams& params);
  void choose_channels();
  [[nodiscard]] Reading decode(std::span<const std::uint8_t> scan) const;

  HostTime host_;
  std::filesystem::path folder_;
  bool monotonic_ = false;
  double rate_hz_ = 0;
  ScanLayout layout_;
  std::vector<Axis> axes_;  ///< angular velocity x, y, z, acceleration x, y, z
  ScanChannel timestamp_;
  int fd_ = -1;
  std::vector<std::uint8_t> pending_;  ///< bytes of a scan that has not arrived whole
};

/// Counts readings so that lost ones show as gaps: IIO has no counter, but a rate.
class ReadingCounter {
 public:
  explicit ReadingCounter(double rate_hz) : period_us_(1e6 / rate_hz) {}
  /// The reading's number, or nothing if it is not later than the one before.
  [[nodiscard]] std::optional<std::int64_t> number(Time stamp);
  /// The device started anew at `rate_hz`: the time in between counts as lost.
  void set_rate(double rate_hz) { period_us_ = 1e6 / rate_hz; }

 private:
  double period_us_;
  std::optional<Time> last_;
  std::int64_t number_ = 0;
};

}  // namespace arpent::imu
