// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A network of one's own: a namespace with nothing but loopback and a multicast route on it, so that live tests and
// live replays neither disturb nor hear anybody.
#pragma once

#include <string>

namespace arpent {

/// Moves the calling process (call it before starting threads; children inherit) into a new network namespace, brings
/// loopback up and routes 224.0.0.0/4 over it. As an ordinary user it tries a user namespace as well. Returns an empty
/// string, or why it is not permitted here; then nothing has changed.
[[nodiscard]] std::string enter_private_network();

/// Gives loopback one more address (/32), for servers that need one each; `number` > 0 tells several apart. Meant for a
/// private network: it needs the right to configure this one. Empty, or why not.
[[nodiscard]] std::string add_loopback_address(int number, const std::string& ipv4);

/// A UDP port for a bus of our own outside a namespace, derived from the process id: robots and tests on one machine
/// need different ports, because groups on one port hear each other.
[[nodiscard]] int private_port();

}  // namespace arpent
