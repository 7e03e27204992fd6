// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/process/centre_process.h"

#include <memory>
#include <string>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "mapping/tsdf/map_file.h"
#include "mapping/wire.h"
#include "perception/stereo/rectifier.h"
#include "planning/process/centre_journal.h"
#include "planning/team/wire.h"
#include "planning/viewpoints/level_camera.h"

namespace arpent {
namespace {

constexpr Duration kCycle = std::chrono::milliseconds(100);

planning::LevelCamera camera_of(const CentreConfig& config) {
  const stereo::Rectifier rectifier(load_rig(config.rig).calibration);
  return planning::make_level_camera(rectifier.stereo(), rectifier.T_body_rectified(), config.centre.tsdf.min_range_m,
                                     config.centre.tsdf.max_range_m);
}

}  // namespace

struct CentreProcess::State {
  Config config;
  Bus& bus;
  Clock& clock;
  planning::Centre centre;

  std::unique_ptr<CentreJournal> journal;

  State(const Config& c, Bus& process_bus, Clock& process_clock)
      : config(c), bus(process_bus), clock(process_clock), centre(c.centre, camera_of(c)) {
    if (!config.journal_file.empty()) {
      journal = std::make_unique<CentreJournal>(
          config.journal_file,
          [this](Time time, const std::string& channel, BytesView bytes) { recall(time, channel, bytes); });
    }
  }

  void refuse(const std::string& channel, const std::string& fault) const {
    bus.health().count(channel, "invalid");
    bus.health().warn(channel + ": message dropped: " + fault);
  }

  /// False if it was refused.
  bool take(const map_patch_t& message, Time) {
    const auto patch = mapping::from_wire(message);
    const auto fused = patch ? centre.take(*patch) : Fault{patch.fault()};
    if (!fused) refuse(channels::kTeamPatch, fused.fault());
    return static_cast<bool>(fused);
  }

  bool take(const robot_state_t& message, Time now) {
    const auto state = planning::from_wire(message);
    if (state) centre.take(*state, now);
    if (!state) refuse(channels::kTeamState, state.fault());
    return static_cast<bool>(state);
  }

  bool take(const tour_report_t& message, Time now) {
    const auto report = planning::from_wire(message);
    if (report) centre.take(*report, now);
    if (!report) refuse(channels::kTeamReport, report.fault());
    return static_cast<bool>(report);
  }

  bool take(const tour_t& message, Time) {
    const auto tour = planning::from_wire(message);
    if (tour) centre.recall(*tour);
    if (!tour) refuse(channels::kTour, tour.fault());
    return static_cast<bool>(tour);
  }

  /// What the journal holds.
  void recall(Time time, const std::string& channel, BytesView bytes) {
    const auto decoded = [&](auto message) {
      std::string fault;
      if (!decode_guarded(bytes, message, fault)) return refuse(channel, fault);
      if (take(message, time)) bus.health().count(channel, "recalled");
    };
    if (channel == channels::kTeamPatch) decoded(map_patch_t{});
    if (channel == channels::kTeamState) decoded(robot_state_t{});
    if (channel == channels::kTeamReport) decoded(tour_report_t{});
    if (channel == channels::kTour) decoded(tour_t{});
  }

  template <class Message>
  void receive(const char* channel, const Message& message) {
    if (take(message, clock.now()) && journal) journal->note(clock.now(), channel, encode(message));
  }
  void receive_state(const robot_state_t& message) {
    if (!take(message, clock.now()) || !journal) return;
    journal->note_sometimes(clock.now(), channels::kTeamState, message.robot, encode(message));
  }

  void step() {
    for (const planning::TeamTour& tour : centre.step(clock.now())) {
      const tour_t message = planning::to_wire(tour);
      if (journal) journal->note(clock.now(), channels::kTour, encode(message));
      publish(bus, channels::kTour, message);
    }
    if (journal && !journal->keep(clock.now())) {
      journal.reset();
      bus.health().warn("the disk refuses the journal " + config.journal_file.string() +
                        ": a centre that is started again would begin with an empty map");
    }
  }
};

CentreProcess::CentreProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  subscribe<map_patch_t>(bus, channels::kTeamPatch, {.queue_capacity = 1000, .latency = Duration(config.latency_us)},
                         [this](const map_patch_t& m) { state_->receive(channels::kTeamPatch, m); });
  subscribe<robot_state_t>(bus, channels::kTeamState, {.queue_capacity = 64},
                           [this](const robot_state_t& m) { state_->receive_state(m); });
  subscribe<tour_report_t>(bus, channels::kTeamReport, {.queue_capacity = 64},
                           [this](const tour_report_t& m) { state_->receive(channels::kTeamReport, m); });
  clock.every(kCycle, [this] { state_->step(); });
}

CentreProcess::~CentreProcess() = default;

const planning::Centre& CentreProcess::centre() const {
  return state_->centre;
}

void CentreProcess::finish() {
  if (!state_->config.map_file.empty()) mapping::save_map(state_->config.map_file, state_->centre.map());
}

}  // namespace arpent
