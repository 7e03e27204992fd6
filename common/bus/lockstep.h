// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The lockstep executor: all processes in one OS process, on an in-memory bus with a simulated clock and one ordered
// event queue. Messages are encoded and guarded as in live. A handler runs at its simulated time; what it publishes
// appears its declared latency later, and until then its process is busy: messages wait in the subscription's queue,
// and a full queue drops its oldest. Handlers of different processes due at one time run in parallel; their outputs
// commit in the order in which the processes were added. The same inputs therefore give the same messages in the same
// order, whatever the machine does.
#pragma once

#include <deque>
#include <memory>
#include <queue>
#include <string>
#include <vector>

#include "common/bus/bus.h"

namespace arpent {

class LockstepExecutor {
 public:
  /// Sees every message as it becomes visible on the bus, in order.
  using Tap = std::function<void(Time, const std::string& channel, BytesView)>;

  /// `threads`: handlers that may run at once; the result does not depend on it.
  explicit LockstepExecutor(Time start, int threads = 1);
  ~LockstepExecutor();
  LockstepExecutor(const LockstepExecutor&) = delete;
  LockstepExecutor& operator=(const LockstepExecutor&) = delete;

  /// The bus and the clock of one more process; both live as long as the executor.
  struct Endpoint {
    Bus& bus;
    Clock& clock;
  };
  /// `prefix`: the process is on a bus of its own kind, that of one robot: its channels are prefix + name for all
  /// others
  /// ("R1/" makes R1/POSE of POSE). A name with a slash in it is meant as it stands.
  [[nodiscard]] Endpoint add_process(const std::string& name, const std::string& prefix = "");
  /// From now on the processes of this prefix neither hear nor say anything, but for those named `spared`: a robot's
  /// computer dies.
  void silence(const std::string& prefix, const std::string& spared);

  void set_tap(Tap tap) { tap_ = std::move(tap); }

  /// A message from outside (a log, a test) that becomes visible at `time`, not before now.
  void inject(Time time, const std::string& channel, BytesView bytes);

  /// Runs all events up to and including `time` and sets the clock there.
  void run_until(Time time);
  /// Runs until nothing is left to do; periodic timers alone do not keep it running.
  void run_until_idle();

  [[nodiscard]] Time now() const { return now_; }

 private:
  class ProcessBus;
  struct Event;
  struct Later {
    bool operator()(const Event& a, const Event& b) const;
  };

  void push(Event event);
  /// Makes all events of the earliest time visible, runs what is due, commits the outputs.
  void step();
  void deliver(const Event& event);
  void run_due();
  [[nodiscard]] bool waiting_or_messages() const;

  Time now_;
  int threads_;
  std::uint64_t order_ = 0;
  std::int64_t pending_messages_ = 0;
  std::vector<Event> heap_;
  std::vector<std::unique_ptr<ProcessBus>> processes_;
  Tap tap_;
};

}  // namespace arpent
