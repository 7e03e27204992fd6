// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A chassis' firmware as a process: the stand-ins of drivers/base behind real ports, and events in words that trouble
// them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/config/robot.h"
#include "common/time.h"
#include "drivers/base/wheel_motors.h"
#include "drivers/can/reopening.h"

namespace arpent::tools {

struct MockOptions {
  /// agilex_v2: socket:PATH (it owns the hub) or a CAN interface; wifibot: tcp:PORT, udp:PORT or serial:LINK (a
  /// pseudo-terminal, reached through the link that is made).
  std::string listen;
  BaseConfig base;
  base::MotorParams motors;
};

class Mock {
 public:
  using Words = std::vector<std::string>;

  virtual ~Mock() = default;
  /// Sleeps until something arrives or `longest` is over.
  virtual void wait(Duration longest) = 0;
  virtual void step(Time now, double duration_s) = 0;
  [[nodiscard]] virtual base::WheelMotors& motors() = 0;
  /// Its condition, for people.
  [[nodiscard]] virtual std::string condition() = 0;

  /// Something happens, in words (kEventHelp). False if it is not understood.
  [[nodiscard]] bool apply(const std::string& event);

 protected:
  /// Events that only this kind of chassis knows.
  [[nodiscard]] virtual bool apply_own(const Words& words) = 0;
};

inline constexpr char kEventHelp[] =
    "slip LEFT RIGHT | block on/off | encoder left/right ok/stuck/reversed/doubled | count left/right N; "
    "agilex_v2: button on/off | remote on V W | remote off | battery V | restart; "
    "on a socket: bus active/passive/off/gone | loss SHARE";

/// A number, all of the text.
[[nodiscard]] std::optional<double> to_number(const std::string& text);

/// Throws InputError for options that cannot be used.
[[nodiscard]] std::unique_ptr<Mock> make_mock(const MockOptions& options, const Now& now);
[[nodiscard]] std::unique_ptr<Mock> make_agilex_mock(const MockOptions& options, const Now& now);
[[nodiscard]] std::unique_ptr<Mock> make_wifibot_mock(const MockOptions& options, const Now& now);

}  // namespace arpent::tools
