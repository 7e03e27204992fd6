// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The robot file (config/robots): footprint, limits, the motor base, and which rig it carries.
#pragma once

#include <filesystem>
#include <string>

#include "common/config/config.h"
#include "common/config/limits.h"

namespace arpent {

/// What turns ways of the two sides into motion of the body.
struct BaseGeometry {
  double track_m = 0.583;  ///< effective distance of the sides: skid steering makes it larger than the measured one
  double left_scale = 1.0;
  double right_scale = 1.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("track_m", self.track_m, "effective distance of left and right wheels", config::between(0.05, 5.0));
    visitor.field("left_scale", self.left_scale, "true way of the left side over what its odometer says",
                  config::between(0.5, 2.0));
    visitor.field("right_scale", self.right_scale, "the same on the right", config::between(0.5, 2.0));
  }
};

/// A Wifibot board: its units vary twelvefold between robots.
struct WifibotConfig {
  double odometer_ticks_per_m = 5312;
  double command_ticks_per_mps = 265.6;  ///< the board takes ticks per 50 ms
  bool wake_by_pid = false;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("odometer_ticks_per_m", self.odometer_ticks_per_m, "ticks of an odometer on a metre",
                  config::greater_than(0.0));
    visitor.field("command_ticks_per_mps", self.command_ticks_per_mps, "units of a speed command for 1 m/s",
                  config::greater_than(0.0));
    visitor.field(
        "wake_by_pid", self.wake_by_pid,
        "a board that is silent gets a PID frame (0.80 0.45 0.00): on a Raspberry Pi's header it sends nothing "
        "before one");
  }
};

/// The motor base: docs/robots.md says how to fill it in.
struct BaseConfig {
  std::string protocol = "agilex_v2";
  std::string port = "can0";
  BaseGeometry geometry = {};
  WifibotConfig wifibot = {};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("protocol", self.protocol, "what the base speaks", config::one_of({"agilex_v2", "wifibot"}));
    visitor.field("port", self.port,
                  "agilex_v2: can0, socket:PATH, candump:FILE or bus; wifibot: serial:DEVICE, tcp:HOST[:PORT] or "
                  "udp:HOST[:PORT]",
                  config::required_text());
    BaseGeometry::describe(self.geometry, visitor);
    visitor.group("wifibot", self.wifibot, "a Wifibot board");
  }
};

struct RobotConfig {
  std::string name = "robot";
  std::filesystem::path rig;
  double semi_axis_long_m = 0.55;
  double semi_axis_short_m = 0.25;
  MotionLimits limits = {};
  BaseConfig base = {};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("name", self.name, "name of the robot");
    visitor.field("rig", self.rig, "rig file of its camera", config::required_path());
    visitor.field("semi_axis_long_m", self.semi_axis_long_m, "footprint ellipse, along the heading",
                  config::greater_than(0.0));
    visitor.field("semi_axis_short_m", self.semi_axis_short_m, "footprint ellipse, across it",
                  config::greater_than(0.0));
    MotionLimits::describe(self.limits, visitor);
    visitor.group("base", self.base, "the motor base");
  }
};

}  // namespace arpent
