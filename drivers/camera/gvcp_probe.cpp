// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/gvcp_probe.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>

namespace arpent::camera {
namespace {

constexpr std::uint16_t kGvcpPort = 3956;
constexpr std::uint8_t kRequestId = 0x51;
/// Key 0x42, flags: acknowledge, DISCOVERY_CMD 0x0002, length 0, our request id.
constexpr std::array<std::uint8_t, 8> kDiscovery = {0x42, 0x01, 0x00, 0x02, 0x00, 0x00, 0x00, kRequestId};
/// Status 0, DISCOVERY_ACK 0x0003, length, and the same request id in its last byte.
bool is_acknowledgement(const std::array<std::uint8_t, 1024>& bytes, ssize_t size) {
  return size >= 8 && bytes[2] == 0x00 && bytes[3] == 0x03 && bytes[7] == kRequestId;
}

}  // namespace

bool is_ipv4(const std::string& text) {
  in_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1;
}

bool gige_camera_answers(const std::string& ipv4, Duration patience) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(kGvcpPort);
  if (inet_pton(AF_INET, ipv4.c_str(), &to.sin_addr) != 1) return false;
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  bool answered = false;
  // Connected, so that a refusal (nobody listens there) comes back at once.
  if (connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 &&
      send(fd, kDiscovery.data(), kDiscovery.size(), 0) == static_cast<ssize_t>(kDiscovery.size())) {
    pollfd waiting{fd, POLLIN, 0};
    std::array<std::uint8_t, 1024> bytes{};
    if (poll(&waiting, 1, static_cast<int>(patience.count() / 1000)) > 0) {
      const ssize_t size = recv(fd, bytes.data(), bytes.size(), 0);
      answered = is_acknowledgement(bytes, size);
    }
  }
  close(fd);
  return answered;
}

}  // namespace arpent::camera
