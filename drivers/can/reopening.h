// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What ports on something that can vanish have in common: when to try again, and a file descriptor that closes itself.
#pragma once

#include <unistd.h>

#include <functional>
#include <optional>
#include <utility>

#include "common/time.h"

namespace arpent {

/// The clock of whoever owns a live port: monotonic.
using Now = std::function<Time()>;

class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) : fd_(fd) {}
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~FileDescriptor() { close(); }

  void close() {
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  }
  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] explicit operator bool() const { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

/// Lets an attempt through every 200 ms.
class RetryTimer {
 public:
  [[nodiscard]] bool due(Time now) {
    constexpr Duration kPeriod{200000};
    if (last_ && now - *last_ < kPeriod) return false;
    last_ = now;
    return true;
  }

 private:
  std::optional<Time> last_;
};

}  // namespace arpent
