// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Beats, commands and parts over Cyclone DDS, with DDS Security (docs/teams.md). One thread connects (again and again
// until the interface is there) and receives beats and commands; parts come and go in two threads of their own, so that
// bulk never holds up a beat.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "link/params.h"
#include "link/types.h"

namespace arpent::link {

/// Called from the link's own threads: `part` may run beside the others.
struct LinkEvents {
  std::function<void(const Beat&)> beat;
  std::function<void(const Command&)> command;
  std::function<void(const Part&)> part;
  std::function<void(const std::string& warning)> warn;
};

class DdsLink {
 public:
  /// Throws InputError if keys are missing. Returns at once; connecting goes on by itself. One per process.
  DdsLink(const LinkParams& params, LinkEvents events);
  /// No event comes after it.
  ~DdsLink();
  DdsLink(const DdsLink&) = delete;
  DdsLink& operator=(const DdsLink&) = delete;

  [[nodiscard]] bool connected() const;
  /// False if not connected, or the transport refused. Never waits longer than 10 ms. Not from two threads at once.
  bool write(const Beat& beat);
  bool write(const Command& command);
  /// Sent in their turn. False if so much is waiting (32 MB) that they were dropped.
  bool queue(std::vector<Part> parts);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent::link
