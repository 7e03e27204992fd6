// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/net/private_network.h"

#include <net/route.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "common/net/interface.h"

namespace arpent {
namespace {

bool route_multicast_over_loopback(int socket_fd) {
  char device[] = "lo";
  rtentry route{};
  write_ipv4(route.rt_dst, "224.0.0.0");
  write_ipv4(route.rt_genmask, "240.0.0.0");
  write_ipv4(route.rt_gateway, "0.0.0.0");
  route.rt_flags = RTF_UP;
  route.rt_dev = device;
  return ioctl(socket_fd, SIOCADDRT, &route) == 0;
}

}  // namespace

std::string add_loopback_address(int number, const std::string& ipv4) {
  return configure_network("address on loopback", [&](int socket_fd) {
    return set_address(socket_fd, "lo:" + std::to_string(number), ipv4, "255.255.255.255");
  });
}

std::string enter_private_network() {
  if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return net_fault("unshare");
  return configure_network("loopback in a namespace", [](int socket_fd) {
    return bring_up(socket_fd, "lo") && route_multicast_over_loopback(socket_fd);
  });
}

int private_port() {
  return 20000 + static_cast<int>(getpid() % 20000);
}

}  // namespace arpent
