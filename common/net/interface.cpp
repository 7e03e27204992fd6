// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/net/interface.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace arpent {
namespace {

ifreq request_for(const std::string& interface) {
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  return request;
}

}  // namespace

std::string net_fault(const char* what) {
  return std::string(what) + ": " + std::strerror(errno);
}

std::string configure_network(const char* what, const std::function<bool(int socket_fd)>& work) {
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_fd < 0) return net_fault("socket");
  std::string reason = work(socket_fd) ? "" : net_fault(what);
  close(socket_fd);
  return reason;
}

bool write_ipv4(sockaddr& address, const std::string& ipv4) {
  auto* in = reinterpret_cast<sockaddr_in*>(&address);
  in->sin_family = AF_INET;
  return inet_pton(AF_INET, ipv4.c_str(), &in->sin_addr) == 1;
}

bool set_address(int socket_fd, const std::string& interface, const std::string& ipv4, const std::string& netmask) {
  ifreq request = request_for(interface);
  if (!write_ipv4(request.ifr_addr, ipv4) || ioctl(socket_fd, SIOCSIFADDR, &request) != 0) return false;
  return write_ipv4(request.ifr_netmask, netmask) && ioctl(socket_fd, SIOCSIFNETMASK, &request) == 0;
}

bool bring_up(int socket_fd, const std::string& interface) {
  ifreq request = request_for(interface);
  if (ioctl(socket_fd, SIOCGIFFLAGS, &request) != 0) return false;
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | IFF_RUNNING);
  return ioctl(socket_fd, SIOCSIFFLAGS, &request) == 0;
}

}  // namespace arpent
