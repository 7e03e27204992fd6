// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/memory_bus.h"

#include <deque>
#include <random>
#include <vector>

namespace arpent::can {
namespace {

/// Frames that a port keeps until they are read; as on a network interface, later ones are lost.
constexpr std::size_t kReceiveQueue = 256;

struct Place {
  std::string name;
  PortState state = PortState::kActive;
  PortCounters counters;
  std::deque<LoggedFrame> arrived;
};

}  // namespace

struct MemoryBus::State {
  BusFaults faults;
  std::mt19937_64 random;
  Time now;
  std::vector<std::shared_ptr<Place>> places;
  struct InFlight {
    Time arrives;
    std::shared_ptr<const Place> sender;
    CanFrame frame;
  };
  std::deque<InFlight> in_flight;
};

namespace {

class MemoryPort : public CanPort {
 public:
  MemoryPort(std::shared_ptr<MemoryBus::State> bus, std::shared_ptr<Place> place)
      : bus_(std::move(bus)), place_(std::move(place)) {}
  ~MemoryPort() override { std::erase(bus_->places, place_); }
  MemoryPort(const MemoryPort&) = delete;
  MemoryPort& operator=(const MemoryPort&) = delete;

  bool send(const CanFrame& frame) override {
    if (place_->state > PortState::kPassive || frame.size > kMaxBytes) {
      ++place_->counters.refused;
      return false;
    }
    const bool lost = std::uniform_real_distribution<double>()(bus_->random) < bus_->faults.loss;
    if (!lost) bus_->in_flight.push_back({bus_->now + bus_->faults.delay, place_, frame});
    return true;
  }
  std::optional<LoggedFrame> receive() override {
    if (place_->arrived.empty()) return std::nullopt;
    LoggedFrame frame = std::move(place_->arrived.front());
    place_->arrived.pop_front();
    return frame;
  }
  PortState state() const override { return place_->state; }
  PortCounters counters() const override { return place_->counters; }

 private:
  std::shared_ptr<MemoryBus::State> bus_;
  std::shared_ptr<Place> place_;
};

}  // namespace

MemoryBus::MemoryBus(const BusFaults& faults) : state_(std::make_shared<State>()) {
  set_faults(faults);
}
MemoryBus::~MemoryBus() = default;

void MemoryBus::set_faults(const BusFaults& faults) {
  state_->faults = faults;
  state_->random.seed(faults.seed);
}

std::unique_ptr<CanPort> MemoryBus::open(const std::string& name) {
  state_->places.push_back(std::make_shared<Place>(Place{name, PortState::kActive, {}, {}}));
  return std::make_unique<MemoryPort>(state_, state_->places.back());
}

void MemoryBus::advance(Time now) {
  state_->now = now;
  while (!state_->in_flight.empty() && state_->in_flight.front().arrives <= now) {
    const State::InFlight& f = state_->in_flight.front();
    for (const auto& place : state_->places) {
      if (place == f.sender || place->state > PortState::kPassive) continue;
      if (place->arrived.size() < kReceiveQueue) {
        place->arrived.push_back({f.arrives, "mem", f.frame});
      } else {
        ++place->counters.overflows;
      }
    }
    state_->in_flight.pop_front();
  }
}

void MemoryBus::set_state(const std::string& name, PortState state) {
  for (const auto& place : state_->places) {
    if (place->name != name) continue;
    if (place->state > PortState::kPassive && state <= PortState::kPassive) ++place->counters.restarts;
    place->state = state;
    if (state > PortState::kPassive) place->arrived.clear();
  }
}

}  // namespace arpent::can
