// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A CAN bus between processes without CAN hardware: a broadcast hub on a local socket, owned by the stand-in of the
// base, and the port that drivers open on it. Behind the hub is a MemoryBus, with all of its faults; clients hear of
// states by error frames, as from Linux.
#pragma once

#include <memory>
#include <string>

#include "drivers/can/can_port.h"
#include "drivers/can/memory_bus.h"
#include "drivers/can/reopening.h"

namespace arpent::can {

/// The hub is itself a place on its bus. It has no thread: it forwards when wait() or a method of the port is called.
class LocalHub : public CanPort {
 public:
  /// Throws InputError if the path cannot be used or another hub lives there.
  LocalHub(const std::string& path, Now now);
  ~LocalHub() override;

  bool send(const CanFrame& frame) override;
  std::optional<LoggedFrame> receive() override;
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] PortCounters counters() const override;

  /// Sleeps until something arrives or `longest` is over, and forwards.
  void wait(Duration longest);
  void set_faults(const BusFaults& faults);
  /// The state of every client's controller; kGone cuts the connections and refuses new ones.
  void set_client_state(PortState state);
  [[nodiscard]] int clients() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A client. It connects again by itself every 200 ms.
class LocalPort : public CanPort {
 public:
  /// Throws InputError for a path that no socket can have.
  LocalPort(std::string path, Now now);

  bool send(const CanFrame& frame) override;
  std::optional<LoggedFrame> receive() override;
  [[nodiscard]] PortState state() const override { return state_; }
  [[nodiscard]] PortCounters counters() const override { return counters_; }
  [[nodiscard]] std::string fault() const override { return fault_; }

 private:
  void open();
  void lose(const std::string& reason);

  std::string path_;
  Now now_;
  FileDescriptor socket_;
  RetryTimer retry_;
  PortState state_ = PortState::kGone;
  PortCounters counters_;
  std::string fault_;
  bool was_open_ = false;
};

}  // namespace arpent::can
