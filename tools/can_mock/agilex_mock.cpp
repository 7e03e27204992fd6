// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <time.h>

#include <map>

#include "common/error.h"
#include "drivers/base/agilex_chassis.h"
#include "drivers/can/local_hub.h"
#include "drivers/can/socketcan_port.h"
#include "tools/can_mock/mock.h"

namespace arpent::tools {
namespace {

/// A CAN interface does not wake us: it is looked at so often.
constexpr Duration kPoll{2000};

const char* describe(base::agilex::Mode mode) {
  switch (mode) {
    case base::agilex::Mode::kStandby:
      return "standby";
    case base::agilex::Mode::kCan:
      return "CAN";
    case base::agilex::Mode::kUart:
      return "UART";
    case base::agilex::Mode::kRemote:
      return "remote control";
  }
  return "";
}

class AgilexMock : public Mock {
 public:
  AgilexMock(std::unique_ptr<can::CanPort> port, const MockOptions& options)
      : port_(std::move(port)),
        hub_(dynamic_cast<can::LocalHub*>(port_.get())),
        chassis_({.motors = options.motors}, *port_) {}

  void wait(Duration longest) override {
    if (hub_ != nullptr) return hub_->wait(longest);
    const timespec pause{0, std::min(longest, kPoll).count() * 1000};
    nanosleep(&pause, nullptr);
  }
  void step(Time now, double duration_s) override { chassis_.step(now, duration_s); }
  base::WheelMotors& motors() override { return chassis_.motors(); }
  std::string condition() override {
    return fmt::format("mode {}{}", describe(chassis_.mode()),
                       hub_ != nullptr ? fmt::format(", {} clients", hub_->clients()) : "");
  }

 protected:
  bool apply_own(const Words& words) override {
    const auto is = [&](std::size_t count, const char* first, const char* second = nullptr) {
      return words.size() == count && words[0] == first && (second == nullptr || words[1] == second);
    };
    if (is(1, "restart")) {
      chassis_.restart();
    } else if (is(2, "button", "on") || is(2, "button", "off")) {
      chassis_.press_emergency_button(words[1] == "on");
    } else if (is(2, "remote", "off")) {
      chassis_.take_remote_control(false);
    } else if (is(4, "remote", "on")) {
      const auto speed = to_number(words[2]), turn = to_number(words[3]);
      if (!speed || !turn) return false;
      chassis_.take_remote_control(true, {*speed, *turn});
    } else if (is(2, "battery") && to_number(words[1])) {
      chassis_.set_battery_v(*to_number(words[1]));
    } else {
      return hub_ != nullptr && apply_to_bus(words);
    }
    return true;
  }

 private:
  bool apply_to_bus(const Words& words) {
    static const std::map<std::string, can::PortState> kStates{{"active", can::PortState::kActive},
                                                               {"passive", can::PortState::kPassive},
                                                               {"off", can::PortState::kBusOff},
                                                               {"gone", can::PortState::kGone}};
    if (words.size() != 2) return false;
    const auto state = kStates.find(words[1]);
    if (words[0] == "bus" && state != kStates.end()) {
      hub_->set_client_state(state->second);
      return true;
    }
    const auto loss = to_number(words[1]);
    if (words[0] != "loss" || !loss || *loss < 0 || *loss > 1) return false;
    hub_->set_faults({.loss = *loss, .delay = Duration(0)});
    return true;
  }

  std::unique_ptr<can::CanPort> port_;
  can::LocalHub* hub_;  ///< the port, if it is a hub
  base::AgilexChassis chassis_;
};

}  // namespace

std::unique_ptr<Mock> make_agilex_mock(const MockOptions& options, const Now& now) {
  constexpr std::string_view kSocket = "socket:";
  const std::string& listen = options.listen;
  if (listen.compare(0, kSocket.size(), kSocket) == 0) {
    return std::make_unique<AgilexMock>(std::make_unique<can::LocalHub>(listen.substr(kSocket.size()), now), options);
  }
  if (listen.empty() || listen.find_first_of(":/ ") != std::string::npos) {
    throw InputError("can-mock: --listen '" + listen + "': must be socket:PATH or a CAN interface");
  }
  const std::vector<std::uint32_t> commands{base::agilex::kMotionCommandId, base::agilex::kModeCommandId,
                                            base::agilex::kClearErrorsId};
  return std::make_unique<AgilexMock>(std::make_unique<can::SocketCanPort>(listen, commands, now), options);
}

}  // namespace arpent::tools
