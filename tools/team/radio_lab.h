// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A team's stations on one machine, for live tests and benches of the radio link: each has a network namespace of its
// own with its own LCM bus on it, runs a real team_link_process, and reaches the others only through a hub that loses
// and delays frames (common/net/tap_hub.h). Whoever uses it plays the robots on the buses.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/lcm_bus.h"
#include "common/net/tap_hub.h"

namespace arpent::tools {

struct LabStation {
  std::string name;
  std::string role = "robot";
  std::filesystem::path keys = {};         ///< empty: without security
  std::vector<std::string> settings = {};  ///< more of them, "key=value"
};

class RadioLab {
 public:
  /// `bin`: where team_link_process is. `scratch`: for its output. `subscribe` is called for each station before its
  /// bus runs; what it subscribes is handled in a thread of that station. Throws InputError if a network is refused
  /// (radio_network_refused() says so before).
  RadioLab(const std::vector<LabStation>& stations, const AirParams& air, const std::filesystem::path& bin,
           const std::filesystem::path& scratch, const std::function<void(int station, LcmBus&)>& subscribe);
  ~RadioLab();

  [[nodiscard]] TapHub& air();
  /// To publish on, from any thread.
  [[nodiscard]] Bus& bus(int station);
  void start_link(int station);
  /// SIGKILL: as if the power went.
  void kill_link(int station);
  /// The newest health of the station's link: counters by name.
  [[nodiscard]] std::int64_t counter(int station, const std::string& name) const;

 private:
  struct Member;
  std::unique_ptr<TapHub> air_;
  std::vector<std::unique_ptr<Member>> members_;
};

}  // namespace arpent::tools
