// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// radio_process: in lockstep it stands in for what carries messages between robots (team_link): it takes what each
// robot and the centre send from their buses, and puts it on the others' as received. It looks into no message.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "sim/radio/radio.h"

namespace arpent {

struct RadioConfig {
  std::string robots = "R1";
  std::string centre = "centre";
  int seed = 1;
  sim::RadioParams radio;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("robots", self.robots, "names of the robots, with commas between", config::required_text());
    visitor.field("centre", self.centre, "name of the centre's bus", config::required_text());
    visitor.field("seed", self.seed, "seed of losses", config::at_least(0));
    visitor.group("radio", self.radio, "the air");
  }
};

class RadioProcess {
 public:
  using Config = RadioConfig;
  static constexpr char kName[] = "radio_process";
  static constexpr char kHelp[] = "Simulates the radio between robots.";

  RadioProcess(const Config& config, Bus& bus, Clock& clock);
  ~RadioProcess();

  void finish() {}
  [[nodiscard]] const std::map<std::string, std::int64_t>& bytes_by_channel() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
