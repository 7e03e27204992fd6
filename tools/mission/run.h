// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Runs a mission, in lockstep (all in this process, simulated time, the same bytes each time) or live (separate
// processes on a bus of their own, in real time), logs all of it, and gathers what figures and reports are made of.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/log/event_log.h"
#include "common/mesh.h"
#include "common/twist2.h"
#include "control/wire.h"
#include "mapping/wire.h"
#include "planning/wire.h"
#include "tools/evaluation/trajectory.h"
#include "tools/mission/mission_file.h"
#include "tools/stack/lockstep_stack.h"

namespace arpent::tools {

struct MissionOptions {
  std::filesystem::path out;  ///< folder for the log and everything else
  int threads = 2;
  bool live = false;
  std::filesystem::path bin_folder;  ///< live: where the executables are
  bool progress = true;
};

/// One message of a trajectory's kind.
struct StampedTwist {
  Time stamp;
  Twist2 commanded;
};

/// What the centre of a team gave to a robot.
struct Allotment {
  Time stamp;
  std::string robot;
  std::size_t viewpoints = 0;
};

/// Progress bars have so many steps.
inline constexpr std::size_t kProgressSteps = 1000;

[[nodiscard]] inline bool has_ended(const planning::MissionReport& report) {
  return report.state == planning::MissionState::kDone || report.state == planning::MissionState::kAborted;
}

struct MissionResult {
  std::vector<planning::MissionReport> reports;
  evaluation::Trajectory truth;     ///< body in world
  evaluation::Trajectory estimate;  ///< POSE, as far as it is in the world frame
  std::vector<control::PathOrder> paths;
  std::vector<StampedTwist> commands;  ///< what was sent to the base
  std::vector<Allotment> allotments;   ///< in a team: all tours that reached the robot's bus, others' too
  std::optional<mapping::MapStatus> map;
  TriangleMesh mesh;
  std::map<std::string, ProcessFigures> processes;
  std::int64_t pairs = 0;
  int collisions = 0;
  int estops = 0;
  std::uint32_t log_crc = 0;  ///< over all that was published, in order
  double cpu_s = 0;
  double wall_s = 0;
  std::filesystem::path log;
  std::string log_fault;  ///< why the log is not complete; all else is

  [[nodiscard]] bool done() const { return !reports.empty() && reports.back().state == planning::MissionState::kDone; }
  [[nodiscard]] bool ended() const { return !reports.empty() && has_ended(reports.back()); }
};

/// Closes a log; what is wrong with it in a sentence, or nothing.
[[nodiscard]] std::string close_log(LogWriter& log);

/// Gathers a result from the messages of a run, in order; writes them to `log` if there is one, images
/// compressed.
class MissionCollector {
 public:
  MissionCollector(MissionResult& result, LogWriter* log) : result_(result), log_(log) {}
  void take(Time time, const std::string& channel, BytesView bytes);
  /// The disk has refused: the log has ended.
  [[nodiscard]] bool log_was_refused() const { return refused_; }
  /// Closes the log, which there must be; what it lacks is in the result.
  void close();

 private:
  MissionResult& result_;
  LogWriter* log_;
  bool refused_ = false;
};

[[nodiscard]] MissionResult run_mission(const MissionSpec& spec, const MissionOptions& options);

}  // namespace arpent::tools
