// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `calibrate imu`: the noise of an inertial unit from a log at rest; Kalibr's imu.yaml and a report.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "calib/allan.h"

namespace arpent::tools {

/// Six axes (gyro x, y, z [rad/s], accelerometer x, y, z [m/s^2]) read at a steady rate.
struct StaticImu {
  double period_s = 0;
  std::array<std::vector<double>, 6> axes;
  std::size_t filled = 0;  ///< lost readings, replaced by the one before
};

/// IMU of a log. Throws InputError: no readings, less than ten minutes, an unsteady clock, more than 0.1 % lost, or a
/// unit that was moved.
[[nodiscard]] StaticImu load_static_imu(const std::filesystem::path& log);

struct ImuNoiseResult {
  double rate_hz = 0, duration_s = 0;
  std::array<std::vector<calib::AllanPoint>, 6> curves;
  std::array<calib::AxisNoise, 6> axes;
};
[[nodiscard]] ImuNoiseResult measure_imu_noise(const StaticImu& imu);

/// Kalibr's imu.yaml: per sensor the root mean square of its axes; a random walk that the record does not show is
/// written as its upper bound.
[[nodiscard]] std::string to_imu_yaml(const ImuNoiseResult& result);
/// Lines for the terminal, with advice.
[[nodiscard]] std::string summarize(const ImuNoiseResult& result);
/// `folder`/imu.yaml, allan.csv, report.html.
void write_imu_files(const ImuNoiseResult& result, const std::filesystem::path& folder);

}  // namespace arpent::tools
