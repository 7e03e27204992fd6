// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a station must be told: its name, the network, the keys, and how much of the air its patches may take.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>

#include "common/config/fields.h"
#include "link/types.h"

namespace arpent::link {

/// Text of these characters only: it goes into Cyclone's configuration.
[[nodiscard]] inline config::Rule<std::string> plain_text(const std::string& what, const std::string& allowed) {
  return {what, [allowed](const std::string& text) {
            return std::all_of(text.begin(), text.end(), [&](char c) {
              return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                     allowed.find(c) != std::string::npos;
            });
          }};
}

[[nodiscard]] inline config::Rule<std::string> at_most_characters(std::size_t count) {
  return {"at most " + std::to_string(count) + " characters",
          [count](const std::string& text) { return text.size() <= count; }};
}

struct LinkParams {
  std::string interface;
  std::string peers;
  int domain = 42;
  std::string security = "on";
  std::filesystem::path keys;
  double bulk_rate_mbps = 1.0;
  int patch_history = 4096;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("interface", self.interface, "network interface of the radio, e.g. wlan0; lo for one machine",
                  config::required_text(), plain_text("an interface's name", "_.-"));
    visitor.field("peers", self.peers,
                  "addresses of the other stations, with commas between: everything goes to each by unicast; empty: "
                  "multicast",
                  plain_text("addresses with commas between", ".:-,"));
    visitor.field("domain", self.domain, "DDS domain: teams in reach of each other need different ones",
                  config::between(0, 230));
    visitor.field("security", self.security, "off only for a bench: everybody in reach may then command",
                  config::one_of({"on", "off"}));
    visitor.field("keys", self.keys, "this station's folder, made by ./arpent team keys");
    visitor.field(
        "bulk_rate_mbps", self.bulk_rate_mbps,
        "patches leave no faster than this, overhead included; times all stations it stays below the rate of the air",
        config::between(0.01, 1000.0));
    visitor.field("patch_history", self.patch_history,
                  "pieces of patches (8 kB at most each) that are kept for stations that come late",
                  config::between(1, 100000));
  }
};

struct StationParams {
  std::string station;
  double command_expiry_s = 3.0;
  double silent_after_s = 1.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("station", self.station, "this station's name, the same as in its certificate",
                  config::required_text(), plain_text("letters, digits, _ and -", "_-"),
                  at_most_characters(kMaxStationName));
    visitor.field("command_expiry_s", self.command_expiry_s, "a tour that may be older than this is not passed on",
                  config::between(0.1, 1000.0));
    visitor.field("silent_after_s", self.silent_after_s, "a station that was not heard for so long counts as silent",
                  config::between(0.1, 60.0));
  }
};

}  // namespace arpent::link
