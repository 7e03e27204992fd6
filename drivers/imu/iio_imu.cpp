// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/iio_imu.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

namespace arpent::imu {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAxes[] = {"in_anglvel_x", "in_anglvel_y", "in_anglvel_z",
                                 "in_accel_x",   "in_accel_y",   "in_accel_z"};
constexpr const char* kTimestamp = "in_timestamp";
constexpr const char* kRateFiles[] = {"sampling_frequency", "in_anglvel_sampling_frequency",
                                      "in_accel_sampling_frequency"};
constexpr std::size_t kReadBytes = 16384;

std::string read_text(const fs::path& file) {
  std::string text;
  if (!std::getline(std::ifstream(file), text)) throw ImuLost(file.string() + ": cannot be read");
  return text;
}

double read_number(const fs::path& file) {
  const std::string text = read_text(file);
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || !std::isfinite(value)) {
    throw ImuLost(fmt::format("{}: '{}' is no number", file.string(), text));
  }
  return value;
}

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text << std::flush;
  if (!out) throw ImuLost(fmt::format("{}: '{}' cannot be written: {}", file.string(), text, std::strerror(errno)));
}

/// The device's folder, by its own name or by the name that the driver gave it.
fs::path find_device(const IioParams& params) {
  if (fs::is_directory(params.sysfs / params.device)) return params.sysfs / params.device;
  std::error_code none;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(params.sysfs, none)) {
    if (fs::exists(entry.path() / "name") && read_text(entry.path() / "name") == params.device) {
      found.push_back(entry.path());
    }
  }
  if (found.empty()) throw ImuLost(fmt::format("no IIO device {} in {}", params.device, params.sysfs.string()));
  if (found.size() > 1) throw ImuLost("several IIO devices are called " + params.device + ": name its folder");
  return found.front();
}

/// A property of the axis, or of all axes of its kind: in_accel_x_scale or in_accel_scale.
double axis_number(const fs::path& folder, const std::string& axis, const std::string& what, double missing) {
  const std::string kind = axis.substr(0, axis.size() - 2);
  for (const std::string& name : {axis + what, kind + what}) {
    if (fs::exists(folder / name)) return read_number(folder / name);
  }
  return missing;
}

ScanChannel read_channel(const fs::path& folder, const std::string& name) {
  const fs::path elements = folder / "scan_elements";
  if (!fs::exists(elements / (name + "_type"))) {
    throw ImuLost(fmt::format("{}: has no channel {} (gyroscope and accelerometer must be one device, with timestamps)",
                              folder.string(), name));
  }
  const auto type = parse_channel_type(read_text(elements / (name + "_type")));
  if (!type) throw ImuLost(name + ": " + type.fault());
  return {name, static_cast<int>(read_number(elements / (name + "_index"))), *type, 0};
}

bool is_ours(const std::string& name) {
  return name == kTimestamp || std::find(std::begin(kAxes), std::end(kAxes), name) != std::end(kAxes);
}

/// Ours on, others off: an element that we do not know of would shift the rest.
void enable_channels(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder / "scan_elements")) {
    const std::string file = entry.path().filename().string();
    if (file.size() < 4 || file.substr(file.size() - 3) != "_en") continue;
    write_text(entry.path(), is_ours(file.substr(0, file.size() - 3)) ? "1" : "0");
  }
}

}  // namespace

IioImu::IioImu(const IioParams& params, const HostTime& host) : host_(host), folder_(find_device(params)) {
  write_text(folder_ / "buffer" / "enable", "0");
  choose_clock();
  choose_rate(params);
  if (!params.trigger.empty()) write_text(folder_ / "trigger" / "current_trigger", params.trigger);
  enable_channels(folder_);
  choose_channels();
  write_text(folder_ / "buffer" / "length", std::to_string(params.buffer_readings));
  write_text(folder_ / "buffer" / "enable", "1");
  const fs::path device = params.dev / folder_.filename();
  fd_ = open(device.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) throw ImuLost(fmt::format("opening {}: {}", device.string(), std::strerror(errno)));
}

IioImu::~IioImu() {
  close(fd_);
  std::ofstream(folder_ / "buffer" / "enable") << "0";  // the device may be gone: nothing to be said about it here
}

void IioImu::choose_clock() {
  const fs::path file = folder_ / "current_timestamp_clock";
  monotonic_ = fs::exists(file);
  if (monotonic_) write_text(file, "monotonic");
}

void IioImu::choose_rate(const IioParams& params) {
  rate_hz_ = params.rate_hz;
  for (const char* name : kRateFiles) {
    if (!fs::exists(folder_ / name)) continue;
    write_text(folder_ / name, fmt::format("{:g}", params.rate_hz));
    rate_hz_ = read_number(folder_ / name);
  }
  if (rate_hz_ <= 0) throw ImuLost(folder_.string() + ": says that it samples at no rate");
}

void IioImu::choose_channels() {
  std::vector<ScanChannel> channels;
  for (const char* axis : kAxes) channels.push_back(read_channel(folder_, axis));
  channels.push_back(read_channel(folder_, kTimestamp));
  layout_ = lay_out(std::move(channels));
  const auto channel = [this](const std::string& name) {
    return *std::find_if(layout_.channels.begin(), layout_.channels.end(),
                         [&](const auto& c) { return c.name == name; });
  };
  for (const char* axis : kAxes) {
    axes_.push_back({channel(axis), axis_number(folder_, axis, "_scale", 1), axis_number(folder_, axis, "_offset", 0)});
  }
  timestamp_ = channel(kTimestamp);
}

Reading IioImu::decode(std::span<const std::uint8_t> scan) const {
  const auto value = [&](std::size_t axis) {
    const Axis& a = axes_[axis];
    return (static_cast<double>(raw_value(scan, a.channel)) + a.offset) * a.scale;
  };
  const Duration stamp(raw_value(scan, timestamp_) / 1000);
  return {monotonic_ ? host_.from_monotonic(stamp) : host_.from_realtime(stamp),
          {value(0), value(1), value(2)},
          {value(3), value(4), value(5)}};
}

std::vector<Reading> IioImu::read() {
  std::vector<Reading> readings;
  std::array<std::uint8_t, kReadBytes> bytes;
  const ssize_t size = ::read(fd_, bytes.data(), bytes.size());
  if (size < 0 && errno != EAGAIN && errno != EINTR) {
    throw ImuLost(fmt::format("reading {}: {}", folder_.filename().string(), std::strerror(errno)));
  }
  if (size > 0) pending_.insert(pending_.end(), bytes.begin(), bytes.begin() + size);
  std::size_t at = 0;
  for (; at + layout_.bytes <= pending_.size(); at += layout_.bytes) {
    readings.push_back(decode({pending_.data() + at, layout_.bytes}));
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(at));
  return readings;
}

std::optional<std::int64_t> ReadingCounter::number(Time stamp) {
  if (last_ && stamp <= *last_) return std::nullopt;
  // Clocks of sensors are off by a few percent; half a period more than one means that one is missing.
  if (last_) {
    const double periods = static_cast<double>((stamp - *last_).count()) / period_us_;
    number_ += std::max<std::int64_t>(1, std::llround(periods));
  }
  last_ = stamp;
  return number_;
}

}  // namespace arpent::imu
