// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/process/base_driver_process.h"

#include <arpent/estop_t.hpp>
#include <utility>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/robot.h"
#include "drivers/base/process/open_base.h"
#include "drivers/base/wire.h"

namespace arpent {
namespace {

using base::GateState;

/// The newest command counts; requests and stops are few and none may be lost.
constexpr int kCommandQueue = 1;
constexpr int kRequestQueue = 16;
constexpr std::size_t kMaxBytes = 4096;

RobotConfig load_robot(const BaseDriverConfig& config) {
  auto robot = config::load<RobotConfig>(config.robot);
  if (!config.port.empty()) robot.base.port = config.port;
  return robot;
}

}  // namespace

struct BaseDriverProcess::State {
  Bus& bus;
  Clock& clock;
  base::OpenBase base;
  std::int64_t sequence = 0;
  std::string fault;
  std::int64_t bad_frames = 0, refused_sends = 0;

  State(const Config& config, Bus& process_bus, Clock& process_clock)
      : bus(process_bus),
        clock(process_clock),
        base(load_robot(config), {config.dry_run, config.can_log}, process_bus, process_clock) {}

  base::BaseDriver& driver() { return base.driver(); }
  Health& health() { return bus.health(); }

  void refuse(const char* channel, const char* counter, const std::string& reason) {
    health().count(channel, counter);
    health().warn(std::string(channel) + ": " + reason);
  }

  void on_command(const wheel_command_t& message) {
    const auto command = base::from_wire(message);
    if (!command) return refuse(channels::kWheelCommand, "invalid", command.fault());
    if (const auto reason = driver().gate().offer(command->twist, clock.now())) {
      refuse(channels::kWheelCommand, "refused", *reason);
    }
  }

  void on_estop(BytesView bytes) {
    driver().stop();
    estop_t message;
    std::string garbled;
    const bool readable = decode_guarded(bytes, message, garbled);
    health().count(channels::kEstop, readable ? "handled" : "undecodable");
    report(readable ? "emergency stop by " + message.source + ": " + message.reason
                    : "emergency stop by an unreadable message: " + garbled);
  }

  void on_request(const base_request_t& message) {
    const auto request = base::from_wire(message);
    if (!request) return refuse(channels::kBaseRequest, "invalid", request.fault());
    if (const auto reason = act(request->action)) {
      refuse(channels::kBaseRequest, "refused", "request of " + request->source + " refused: " + *reason);
    }
  }

  std::optional<std::string> act(base::Action action) {
    switch (action) {
      case base::Action::kArm:
        if (!driver().status().heard) return "the base does not answer";
        if (auto reason = driver().gate().arm()) return reason;
        fault.clear();
        return std::nullopt;
      case base::Action::kRelease:
        return driver().gate().release(clock.now());
      case base::Action::kDisarm:
        driver().gate().disarm();
    }
    return std::nullopt;
  }

  void report(const std::string& what) {
    fault = what;
    health().error(what);
  }

  /// One cycle of 20 ms; live and lockstep call it alike.
  void step(Time now) {
    for (const std::string& newly : driver().step(now)) report(newly);
    const base::BaseStatus& status = driver().status();
    if (!status.heard) health().warn("the base does not answer");
    count_new("bad", status.bad_frames, bad_frames);
    count_new("refused", status.refused_sends, refused_sends);
    publish(bus, channels::kWheelState, base::to_wire({sequence++, status, driver().gate().state(), fault}));
  }

  void count_new(const char* counter, std::int64_t now, std::int64_t& before) {
    const std::int64_t more = now - std::exchange(before, now);
    if (more > 0) health().count("base", counter, more);
  }
};

BaseDriverProcess::BaseDriverProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  State* const state = state_.get();
  subscribe<wheel_command_t>(bus, channels::kWheelCommand, {.queue_capacity = kCommandQueue, .max_bytes = kMaxBytes},
                             [state](const wheel_command_t& message) { state->on_command(message); });
  subscribe<base_request_t>(bus, channels::kBaseRequest, {.queue_capacity = kRequestQueue, .max_bytes = kMaxBytes},
                            [state](const base_request_t& message) { state->on_request(message); });
  bus.subscribe_bytes(channels::kEstop, {.queue_capacity = kRequestQueue},
                      [state](BytesView bytes) { state->on_estop(bytes); });
  clock.every(base::kCycle, [state] { state->step(state->clock.now()); });
  clock.every(base::kExpiryPeriod, [state] { state->driver().expire(state->clock.now()); });
}

BaseDriverProcess::~BaseDriverProcess() = default;

void BaseDriverProcess::finish() {
  state_->driver().gate().disarm();
  state_->step(state_->clock.now());
}

}  // namespace arpent
