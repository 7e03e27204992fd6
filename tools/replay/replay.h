// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Replays a log of stereo pairs through depth, odometry and mapping, and of a robot's drive through tags and the fused
// pose too: in lockstep (all in this process, simulated time, the same bytes each time) or live (separate processes,
// lcm-logplayer and lcm-logger on a bus of their own). Compares the two, and both with what the log says.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/mesh.h"
#include "mapping/process/mapping_process.h"
#include "mapping/wire.h"
#include "perception/odometry/wire.h"
#include "perception/process/depth_process.h"
#include "perception/process/odometry_process.h"
#include "perception/process/pose_process.h"
#include "perception/process/tag_process.h"
#include "tools/evaluation/trajectory.h"
#include "tools/stack/lockstep_stack.h"

namespace arpent::tools {

/// Parameters of the processes for one log; comes with the log (CONFIG event "replay") and may be overridden.
struct ReplayConfig {
  std::string trajectory_frame = "body";
  DepthConfig depth;
  OdometryConfig odometry;
  TagConfig tags;
  PoseConfig pose;
  MappingConfig mapping;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("trajectory_frame", self.trajectory_frame, "frame whose path is written",
                  config::one_of({"cam0", "body", "imu"}));
    visitor.group("depth", self.depth, "depth_process");
    visitor.group("odometry", self.odometry, "odometry_process");
    visitor.group("tags", self.tags, "tag_process");
    visitor.group("pose", self.pose, "pose_process");
    visitor.group("mapping", self.mapping, "mapping_process");
  }
};

/// A log and what it brings along.
struct ReplayInput {
  std::filesystem::path log;
  std::filesystem::path rig_file;  ///< extracted beside the outputs
  ReplayConfig config;
  Time begin{};                       ///< of the first event that is no configuration
  std::vector<Time> pairs;            ///< times of the stereo pairs
  bool drive = false;                 ///< the log has the wheels of a drive, so that tags and the fused pose can run
  evaluation::Trajectory truth;       ///< T_world_body; empty if unknown
  std::vector<std::string> warnings;  ///< damage of the log
};

/// Opens `log`; its rig is written into `work_folder`. `rig` overrides the log's own; `settings` are "key=value" on top
/// of the log's parameters. Throws InputError if the log cannot be read, has no stereo pairs, or no rig is known.
[[nodiscard]] ReplayInput open_log(const std::filesystem::path& log, const std::filesystem::path& work_folder,
                                   const std::filesystem::path& rig, const std::vector<std::string>& settings);

struct ReplayOptions {
  double start_s = 0;  ///< seek: passes over what comes before, from the log's beginning
  double duration_s = 1e9;
  int step = 1;      ///< use each n-th pair
  double speed = 1;  ///< live only
  /// Of depth, odometry, tag, pose, mapping; empty: all that the log has the inputs for.
  std::set<std::string> processes;
  std::filesystem::path out_log;  ///< what was published, as a log; empty: nowhere
  int threads = 2;
};

struct ReplayResult {
  std::int64_t pairs = 0;
  std::vector<odometry::BodyOdometry> odometry;
  std::map<std::int64_t, std::uint32_t> depth_crc;    ///< by utime, CRC-32C of the whole DEPTH message
  std::optional<mapping::MapStatus> map;              ///< the last
  std::map<std::int64_t, std::uint32_t> map_digests;  ///< by utime
  TriangleMesh mesh;
  std::map<std::string, ProcessFigures> processes;
  /// Each message that the replayed processes published, by channel, in order.
  struct Output {
    Time time;
    std::uint32_t crc;  ///< CRC-32C of the message as logs keep it
  };
  std::map<std::string, std::vector<Output>> outputs;
  std::uint32_t log_crc = 0;  ///< over all that was published, in order: equal runs, equal CRCs
  double cpu_s = 0;
  double wall_s = 0;
};

[[nodiscard]] ReplayResult run_lockstep(const ReplayInput& input, const ReplayOptions& options);
/// Separate processes on a bus of their own. `bin_folder`: where the executables are; `work_folder` gets logs, configs
/// and the map.
[[nodiscard]] ReplayResult run_live(const ReplayInput& input, const ReplayOptions& options,
                                    const std::filesystem::path& bin_folder, const std::filesystem::path& work_folder);

struct ReplayDifference {
  std::int64_t depth_different = 0;  ///< depth messages that differ or exist in one only
  std::int64_t map_different = 0;    ///< map states that do
  bool mesh_equal = false;
  [[nodiscard]] bool identical() const { return depth_different == 0 && map_different == 0 && mesh_equal; }
};
[[nodiscard]] ReplayDifference compare(const ReplayResult& a, const ReplayResult& b);

/// The processes of `options` that this log can feed.
[[nodiscard]] std::set<std::string> processes_to_run(const ReplayInput& input, const ReplayOptions& options);
/// Channels that a process (of those names) publishes.
[[nodiscard]] std::vector<std::string> outputs_of(const std::string& process);

/// Messages that the replay published against those of the same channels in the log.
struct LogComparison {
  std::int64_t compared = 0;   ///< messages that the log has
  std::int64_t different = 0;  ///< of them, those that the replay did not publish alike
  std::int64_t further = 0;    ///< published behind the last of the log: where a live process ended before its inputs
  std::map<std::string, std::int64_t> different_by_channel;
};
/// Only for the whole log; channels that the log has nothing of do not count, nor what was published after its end.
[[nodiscard]] LogComparison compare_with_log(const ReplayInput& input, const ReplayResult& result);

/// The path of `frame` ("body", "imu": the body; "cam0": the left camera, from its own first pose), one row per
/// odometry message.
[[nodiscard]] evaluation::Trajectory trajectory_of(const ReplayResult& result, const ReplayInput& input,
                                                   const std::string& frame);
/// The truth of the same frame, in the same reference frame as far as it is known.
[[nodiscard]] evaluation::Trajectory truth_of(const ReplayInput& input, const std::string& frame);

}  // namespace arpent::tools
