// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/imu_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/atomic_file.h"
#include "common/error.h"
#include "tools/calibrate/motion_log.h"
#include "tools/report/html.h"

namespace arpent::tools {
namespace {

constexpr const char* kAxisNames[] = {"gyro x",          "gyro y",          "gyro z",
                                      "accelerometer x", "accelerometer y", "accelerometer z"};
constexpr const char* kColors[] = {"#c0392b", "#1e8449", "#2471a3", "#e59866", "#7dcea0", "#7fb3d5"};
constexpr double kLeastDurationS = 600, kGoodDurationS = 3 * 3600;
constexpr double kMostLost = 1e-3;
/// A unit at rest turns with its bias; means over a second that differ from the whole's by more are motion.
constexpr double kMovedRadps = 0.03, kMovedMps2 = 0.5;

double seconds_between(const imu::Reading& a, const imu::Reading& b) {
  return 1e-6 * static_cast<double>(to_utime(b.stamp) - to_utime(a.stamp));
}

double median_period_s(const std::vector<imu::Reading>& readings) {
  std::vector<double> periods;
  for (std::size_t i = 1; i < readings.size(); ++i) periods.push_back(seconds_between(readings[i - 1], readings[i]));
  const auto middle = periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
  std::nth_element(periods.begin(), middle, periods.end());
  return *middle;
}

void append(StaticImu& imu, const imu::Reading& reading) {
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    imu.axes[k].push_back(reading.angular_velocity_radps[i]);
    imu.axes[k + 3].push_back(reading.acceleration_mps2[i]);
  }
}

void require_rest(const StaticImu& imu, const std::string& log) {
  const auto window = static_cast<std::size_t>(std::max(1.0, 1 / imu.period_s));
  for (std::size_t k = 0; k < 6; ++k) {
    const auto& axis = imu.axes[k];
    double mean = 0;
    for (const double x : axis) mean += x / static_cast<double>(axis.size());
    for (std::size_t begin = 0; begin + window <= axis.size(); begin += window) {
      double part = 0;
      for (std::size_t i = begin; i < begin + window; ++i) part += axis[i] / static_cast<double>(window);
      if (std::abs(part - mean) < (k < 3 ? kMovedRadps : kMovedMps2)) continue;
      throw InputError(
          fmt::format("{}: the unit was moved {:.0f} s after the start ({} differs by {:.3g}): let it lie still for "
                      "three hours",
                      log, static_cast<double>(begin) * imu.period_s, kAxisNames[k], std::abs(part - mean)));
    }
  }
}

double root_mean_square(double a, double b, double c) {
  return std::sqrt((a * a + b * b + c * c) / 3);
}

double walk_or_bound(const calib::AxisNoise& noise) {
  return noise.random_walk > 0 ? noise.random_walk : noise.random_walk_bound;
}

}  // namespace

StaticImu load_static_imu(const std::filesystem::path& log) {
  const auto readings = read_motion_log(log, [](auto, auto) {}).imu;
  if (readings.size() < 100) throw InputError(log.string() + ": has no IMU readings to speak of");
  StaticImu imu;
  imu.period_s = median_period_s(readings);
  if (!(imu.period_s > 0)) throw InputError(log.string() + ": the readings' times do not advance");
  append(imu, readings.front());
  for (std::size_t i = 1; i < readings.size(); ++i) {
    const double gap = seconds_between(readings[i - 1], readings[i]) / imu.period_s;
    if (!(gap > 0) || gap > 1e5) {
      throw InputError(fmt::format("{}: time jumps by {:.3g} s between two readings: one clock, and no restarts",
                                   log.string(), gap * imu.period_s));
    }
    for (double missing = 1.5; missing < gap; missing += 1) append(imu, readings[i - 1]), ++imu.filled;
    append(imu, readings[i]);
  }
  const double duration_s = imu.period_s * static_cast<double>(imu.axes[0].size());
  if (duration_s < kLeastDurationS) {
    throw InputError(fmt::format("{}: {:.0f} s of readings: ten minutes are the least, three hours are good",
                                 log.string(), duration_s));
  }
  if (static_cast<double>(imu.filled) > kMostLost * static_cast<double>(imu.axes[0].size())) {
    throw InputError(fmt::format("{}: {} of {} readings are missing", log.string(), imu.filled, imu.axes[0].size()));
  }
  require_rest(imu, log.string());
  return imu;
}

ImuNoiseResult measure_imu_noise(const StaticImu& imu) {
  ImuNoiseResult result;
  result.rate_hz = 1 / imu.period_s;
  result.duration_s = imu.period_s * static_cast<double>(imu.axes[0].size());
  for (std::size_t k = 0; k < 6; ++k) {
    result.curves[k] = calib::allan_deviation(imu.axes[k], imu.period_s);
    result.axes[k] = calib::fit_noise(result.curves[k], result.duration_s);
  }
  return result;
}

std::string to_imu_yaml(const ImuNoiseResult& result) {
  const auto& a = result.axes;
  return fmt::format(
      "rostopic: /imu0\nupdate_rate: {:.3f}\naccelerometer_noise_density: {:.6e}\naccelerometer_random_walk: "
      "{:.6e}\ngyroscope_noise_density: {:.6e}\ngyroscope_random_walk: {:.6e}\n",
      result.rate_hz, root_mean_square(a[3].white, a[4].white, a[5].white),
      root_mean_square(walk_or_bound(a[3]), walk_or_bound(a[4]), walk_or_bound(a[5])),
      root_mean_square(a[0].white, a[1].white, a[2].white),
      root_mean_square(walk_or_bound(a[0]), walk_or_bound(a[1]), walk_or_bound(a[2])));
}

std::string summarize(const ImuNoiseResult& result) {
  std::string text = fmt::format("{:.2f} h at {:.1f} Hz\n", result.duration_s / 3600, result.rate_hz);
  for (std::size_t k = 0; k < 6; ++k) {
    const calib::AxisNoise& n = result.axes[k];
    const char* unit = k < 3 ? "rad/s" : "m/s^2";
    text += fmt::format(
        "{}: white noise {:.3g} {}/sqrt(Hz), bias instability {:.3g} {}, random walk {}{:.3g} {}/s/sqrt(Hz)\n",
        kAxisNames[k], n.white, unit, n.bias_instability, unit, n.random_walk > 0 ? "" : "not seen, below ",
        walk_or_bound(n), unit);
  }
  if (result.duration_s < kGoodDurationS) {
    text += fmt::format("the random walk and the bias instability need longer: three hours or more\n");
  }
  return text + "a moving robot shakes its unit: many take 10 times these values for a filter\n";
}

void write_imu_files(const ImuNoiseResult& result, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  atomic_write(folder / "imu.yaml", to_imu_yaml(result));
  std::string csv = "tau_s,gyro_x,gyro_y,gyro_z,accelerometer_x,accelerometer_y,accelerometer_z\n";
  for (std::size_t i = 0; i < result.curves[0].size(); ++i) {
    csv += fmt::format("{:.6g}", result.curves[0][i].tau_s);
    for (const auto& curve : result.curves) csv += fmt::format(",{:.6g}", curve[i].deviation);
    csv += "\n";
  }
  atomic_write(folder / "allan.csv", csv);
  report::Page page("Noise of the inertial unit",
                    fmt::format("{:.2f} h at rest, {:.1f} Hz", result.duration_s / 3600, result.rate_hz));
  for (const std::size_t first : {0U, 3U}) {
    std::vector<report::Curve> curves;
    for (std::size_t k = first; k < first + 3; ++k) {
      curves.push_back({kAxisNames[k], kColors[k], {}});
      for (const auto& p : result.curves[k]) {
        if (p.deviation > 0) curves.back().points.emplace_back(std::log10(p.tau_s), std::log10(p.deviation));
      }
    }
    page.section(first == 0 ? "Gyro" : "Accelerometer");
    page.plot(curves, "log10 of the averaging time [s]",
              first == 0 ? "log10 of the Allan deviation [rad/s]" : "log10 of the Allan deviation [m/s^2]", false);
    std::vector<std::vector<std::string>> rows;
    for (std::size_t k = first; k < first + 3; ++k) {
      const auto& n = result.axes[k];
      rows.push_back(
          {kAxisNames[k], fmt::format("{:.3g}", n.white), fmt::format("{:.3g}", n.bias_instability),
           n.random_walk > 0 ? fmt::format("{:.3g}", n.random_walk) : fmt::format("< {:.3g}", n.random_walk_bound)});
    }
    page.table({"axis", "white noise [/sqrt(Hz)]", "bias instability", "random walk [/s/sqrt(Hz)]"}, rows);
  }
  page.write(folder);
}

}  // namespace arpent::tools
