// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// An IIO device made of files: sysfs as the kernel's driver for a six-axis unit lays it out, and a FIFO as its
// character device.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>

namespace arpent::imu {

class FakeIio {
 public:
  explicit FakeIio(std::filesystem::path root) : root_(std::move(root)) {
    namespace fs = std::filesystem;
    fs::remove_all(root_);
    for (const char* folder : {"scan_elements", "buffer", "trigger"}) fs::create_directories(device() / folder);
    fs::create_directories(root_ / "dev");
    write("name", "bmi160");
    write("current_timestamp_clock", "realtime");
    write("sampling_frequency", "100");
    write("in_anglvel_scale", "0.001");
    write("in_accel_scale", "0.01");
    write("in_accel_x_offset", "100");  // an axis' own property goes before that of its kind
    write("in_accel_offset", "0");
    write("buffer/enable", "0");
    write("buffer/length", "2");
    write("scan_elements/in_temp_en", "1");
    const char* names[] = {"in_anglvel_x", "in_anglvel_y", "in_anglvel_z", "in_accel_x", "in_accel_y", "in_accel_z"};
    for (int i = 0; i < 6; ++i) add_channel(names[i], i, "le:s16/16>>0");
    add_channel("in_timestamp", 6, "le:s64/64>>0");
    mkfifo(chardev().c_str(), 0600);
    fd_ = open(chardev().c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  }
  ~FakeIio() {
    close(fd_);
    std::filesystem::remove_all(root_);
  }
  FakeIio(const FakeIio&) = delete;
  FakeIio& operator=(const FakeIio&) = delete;

  void write(const std::string& file, const std::string& text) const { std::ofstream(device() / file) << text << '\n'; }
  std::string text(const std::string& file) const {
    std::string line;
    std::getline(std::ifstream(device() / file), line);
    return line;
  }
  /// One scan on the character device: the six raw values and the time.
  void send(const std::array<std::int16_t, 6>& raw, std::int64_t stamp_ns) const {
    std::array<char, 24> scan{};  // 12 bytes, 4 of padding, 8 of time
    std::copy_n(reinterpret_cast<const char*>(raw.data()), 12, scan.begin());
    std::copy_n(reinterpret_cast<const char*>(&stamp_ns), 8, scan.begin() + 16);
    send_bytes({scan.data(), scan.size()});
  }
  void send_bytes(const std::string& bytes) const {
    if (::write(fd_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) std::abort();
  }
  std::filesystem::path sysfs() const { return root_ / "devices"; }
  std::filesystem::path dev() const { return root_ / "dev"; }
  std::filesystem::path device() const { return sysfs() / "iio:device0"; }
  std::filesystem::path chardev() const { return dev() / "iio:device0"; }

 private:
  void add_channel(const std::string& name, int index, const std::string& type) const {
    write("scan_elements/" + name + "_en", "0");
    write("scan_elements/" + name + "_index", std::to_string(index));
    write("scan_elements/" + name + "_type", type);
  }
  std::filesystem::path root_;
  int fd_ = -1;
};

}  // namespace arpent::imu
