// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/process/centre_process.h"

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "mapping/tsdf/map_file.h"
#include "mapping/wire.h"
#include "perception/stereo/rectifier.h"
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

  State(const Config& c, Bus& process_bus, Clock& process_clock)
      : config(c), bus(process_bus), clock(process_clock), centre(c.centre, camera_of(c)) {}

  void refuse(const char* channel, const std::string& fault) const {
    bus.health().count(channel, "invalid");
    bus.health().warn(std::string(channel) + ": message dropped: " + fault);
  }

  void take(const map_patch_t& message) {
    const auto patch = mapping::from_wire(message);
    if (!patch) return refuse(channels::kTeamPatch, patch.fault());
    const auto fused = centre.take(*patch);
    if (!fused) refuse(channels::kTeamPatch, fused.fault());
  }

  void take(const robot_state_t& message) {
    const auto state = planning::from_wire(message);
    if (!state) return refuse(channels::kTeamState, state.fault());
    centre.take(*state, clock.now());
  }

  void take(const tour_report_t& message) {
    const auto report = planning::from_wire(message);
    if (!report) return refuse(channels::kTeamReport, report.fault());
    centre.take(*report, clock.now());
  }

  void step() {
    for (const planning::TeamTour& tour : centre.step(clock.now())) {
      publish(bus, channels::kTour, planning::to_wire(tour));
    }
  }
};

CentreProcess::CentreProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  subscribe<map_patch_t>(bus, channels::kTeamPatch, {.queue_capacity = 1000, .latency = Duration(config.latency_us)},
                         [this](const map_patch_t& m) { state_->take(m); });
  subscribe<robot_state_t>(bus, channels::kTeamState, {.queue_capacity = 64},
                           [this](const robot_state_t& m) { state_->take(m); });
  subscribe<tour_report_t>(bus, channels::kTeamReport, {.queue_capacity = 64},
                           [this](const tour_report_t& m) { state_->take(m); });
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
