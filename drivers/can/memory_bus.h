// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A CAN bus in memory, for simulation and tests: every port hears what the others send, in order, after a delay. Faults
// can be made: loss, delay, an error state, a pulled plug. Seeded and without a clock of its own: the same calls give
// the same frames.
#pragma once

#include <memory>
#include <string>

#include "drivers/can/can_port.h"

namespace arpent::can {

struct BusFaults {
  double loss = 0;      ///< share of frames that no one hears
  Duration delay{500};  ///< from sending to arrival; about four frames at 500 kbit/s
  std::uint64_t seed = 1;
};

class MemoryBus {
 public:
  explicit MemoryBus(const BusFaults& faults = {});
  ~MemoryBus();
  MemoryBus(const MemoryBus&) = delete;
  MemoryBus& operator=(const MemoryBus&) = delete;

  /// A new place on the bus; it must not outlive the bus.
  [[nodiscard]] std::unique_ptr<CanPort> open(const std::string& name);
  /// Time moves on: frames sent before `now` minus the delay arrive.
  void advance(Time now);
  void set_faults(const BusFaults& faults);
  /// Puts the named port into a state: beyond kPassive it neither hears nor sends.
  void set_state(const std::string& name, PortState state);

  struct State;

 private:
  std::shared_ptr<State> state_;
};

}  // namespace arpent::can
