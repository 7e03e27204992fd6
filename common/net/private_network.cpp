// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/net/private_network.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <net/route.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace arpent {
namespace {

std::string fault(const char* what) {
  return std::string(what) + ": " + std::strerror(errno);
}

bool bring_loopback_up(int socket_fd) {
  ifreq request{};
  std::strncpy(request.ifr_name, "lo", IFNAMSIZ - 1);
  if (ioctl(socket_fd, SIOCGIFFLAGS, &request) != 0) return false;
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | IFF_RUNNING);
  return ioctl(socket_fd, SIOCSIFFLAGS, &request) == 0;
}

void set_address(sockaddr& address, const char* text) {
  auto* in = reinterpret_cast<sockaddr_in*>(&address);
  in->sin_family = AF_INET;
  inet_pton(AF_INET, text, &in->sin_addr);
}

bool route_multicast_over_loopback(int socket_fd) {
  char device[] = "lo";
  rtentry route{};
  set_address(route.rt_dst, "224.0.0.0");
  set_address(route.rt_genmask, "240.0.0.0");
  set_address(route.rt_gateway, "0.0.0.0");
  route.rt_flags = RTF_UP;
  route.rt_dev = device;
  return ioctl(socket_fd, SIOCADDRT, &route) == 0;
}

bool add_alias(int socket_fd, const std::string& name, const char* ipv4) {
  ifreq request{};
  name.copy(request.ifr_name, IFNAMSIZ - 1);
  set_address(request.ifr_addr, ipv4);
  if (ioctl(socket_fd, SIOCSIFADDR, &request) != 0) return false;
  set_address(request.ifr_netmask, "255.255.255.255");
  return ioctl(socket_fd, SIOCSIFNETMASK, &request) == 0;
}

}  // namespace

std::string add_loopback_address(int number, const std::string& ipv4) {
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_fd < 0) return fault("socket");
  const bool added = add_alias(socket_fd, "lo:" + std::to_string(number), ipv4.c_str());
  const std::string reason = added ? "" : fault("address on loopback");
  close(socket_fd);
  return reason;
}

std::string enter_private_network() {
  if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return fault("unshare");
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_fd < 0) return fault("socket");
  const bool ready = bring_loopback_up(socket_fd) && route_multicast_over_loopback(socket_fd);
  const std::string reason = ready ? "" : fault("loopback in a namespace");
  close(socket_fd);
  return reason;
}

int private_port() {
  return 20000 + static_cast<int>(getpid() % 20000);
}

}  // namespace arpent
