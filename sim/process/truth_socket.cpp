// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/process/truth_socket.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "common/error.h"

namespace arpent {
namespace {

constexpr char kSuffix[] = ".sock";
/// A TRUTH_POSE has some 80.
constexpr std::size_t kMaxBytes = 512;

/// Of the socket; its path is empty if it is too long to be one.
sockaddr_un address_of(const std::filesystem::path& folder, const std::string& name) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = (folder / (name + kSuffix)).string();
  if (path.size() < sizeof(address.sun_path)) std::copy(path.begin(), path.end(), address.sun_path);
  return address;
}

}  // namespace

TruthSocket::TruthSocket(const std::filesystem::path& folder, const std::string& name,
                         const std::vector<std::string>& teammates)
    : folder_(folder), name_(name), teammates_(teammates) {
  const sockaddr_un own = address_of(folder, name);
  if (own.sun_path[0] == '\0') throw InputError("truth_folder: " + folder.string() + " is too long for a socket");
  fd_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  unlink(own.sun_path);  // of a run that crashed
  if (fd_ < 0 || bind(fd_, reinterpret_cast<const sockaddr*>(&own), sizeof(own)) != 0) {
    const std::string reason = std::strerror(errno);
    if (fd_ >= 0) close(fd_);
    throw InputError(std::string("truth_folder: no socket ") + own.sun_path + ": " + reason);
  }
}

TruthSocket::~TruthSocket() {
  close(fd_);
  std::error_code ignored;
  std::filesystem::remove(folder_ / (name_ + kSuffix), ignored);
}

void TruthSocket::send(std::span<const std::uint8_t> message) const {
  for (const std::string& teammate : teammates_) {
    const sockaddr_un to = address_of(folder_, teammate);
    (void)sendto(fd_, message.data(), message.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof(to));
  }
}

void TruthSocket::receive(
    const std::function<void(const std::string& teammate, std::span<const std::uint8_t>)>& take) const {
  std::array<std::uint8_t, kMaxBytes> bytes{};
  while (true) {
    sockaddr_un from{};
    socklen_t size = sizeof(from);
    const ssize_t count = recvfrom(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (count < 0) return;
    from.sun_path[sizeof(from.sun_path) - 1] = '\0';
    const std::string sender = std::filesystem::path(from.sun_path).stem();
    if (std::find(teammates_.begin(), teammates_.end(), sender) == teammates_.end()) continue;
    take(sender, {bytes.data(), static_cast<std::size_t>(count)});
  }
}

}  // namespace arpent
