// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Settings of network interfaces, for networks of one's own (private_network.h, tap_hub.h): the kernel's requests, each
// with whether it was granted.
#pragma once

#include <sys/socket.h>

#include <functional>
#include <string>

namespace arpent {

/// What could not be done, and why (errno).
[[nodiscard]] std::string net_fault(const char* what);

/// Opens a socket to ask through, and runs `work` with it. Empty, or why it returned false.
[[nodiscard]] std::string configure_network(const char* what, const std::function<bool(int socket_fd)>& work);

/// False if `ipv4` is not an address.
bool write_ipv4(sockaddr& address, const std::string& ipv4);
bool set_address(int socket_fd, const std::string& interface, const std::string& ipv4, const std::string& netmask);
bool bring_up(int socket_fd, const std::string& interface);

}  // namespace arpent
