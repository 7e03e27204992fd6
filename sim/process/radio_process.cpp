// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/process/radio_process.h"

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "common/channels.h"
#include "common/split.h"

namespace arpent {
namespace {

/// Deliveries are looked for so often: the radio's resolution.
constexpr Duration kCycle = std::chrono::milliseconds(5);
constexpr std::size_t kPatchHistory = 4096;

}  // namespace

struct RadioProcess::State {
  Bus& bus;
  Clock& clock;
  sim::Radio radio;
  std::string centre;
  std::vector<std::string> robots;
  /// Patches are transient-local: a station that joins gets those of before.
  std::map<std::string, std::deque<sim::RadioBytes>> patches;
  std::set<std::string> present;

  State(const Config& config, Bus& process_bus, Clock& process_clock)
      : bus(process_bus),
        clock(process_clock),
        radio(config.radio, static_cast<std::uint64_t>(config.seed)),
        centre(config.centre),
        robots(split(config.robots, ',')) {}

  /// What `sender` says on `sent`, the others hear on `received`.
  void carry(const std::string& sender, const char* sent, const char* received, bool reliable,
             const std::vector<std::string>& receivers) {
    bus.subscribe_bytes(sender + "/" + sent, {.queue_capacity = 256}, [=, this](BytesView bytes) {
      const auto message = std::make_shared<const Bytes>(bytes.begin(), bytes.end());
      if (present.insert(sender).second) welcome(sender);
      radio.send(clock.now(), sender, received, receivers, reliable, message);
      if (received != channels::kTeamPatch) return;
      patches[sender].push_back(message);
      if (patches[sender].size() > kPatchHistory) patches[sender].pop_front();
    });
  }

  void welcome(const std::string& joined) {
    for (const auto& [sender, sent] : patches) {
      for (const auto& message : sent) radio.send(clock.now(), sender, channels::kTeamPatch, {joined}, true, message);
    }
  }

  void carry_all() {
    for (const std::string& robot : robots) {
      std::vector<std::string> others = robots;
      std::erase(others, robot);
      others.push_back(centre);
      carry(robot, channels::kMapPatch, channels::kTeamPatch, true, others);
      carry(robot, channels::kRobotState, channels::kTeamState, false, others);
      carry(robot, channels::kTourReport, channels::kTeamReport, true, {centre});
    }
    carry(centre, channels::kTour, channels::kTeamTour, true, robots);
  }

  void deliver() {
    for (const auto& delivery : radio.take(clock.now())) {
      bus.publish_bytes(delivery.receiver + "/" + delivery.channel, *delivery.bytes);
    }
  }
};

RadioProcess::RadioProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  state_->carry_all();
  clock.every(kCycle, [this] { state_->deliver(); });
}

RadioProcess::~RadioProcess() = default;

const std::map<std::string, std::int64_t>& RadioProcess::bytes_by_channel() const {
  return state_->radio.bytes_by_channel();
}

}  // namespace arpent
