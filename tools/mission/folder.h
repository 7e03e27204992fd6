// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A mission's folder, read back: what its log says about world, robot, rig and parameters, and all that happened; the
// mesh; what only mission.json knows. The true surface of its world, against which the mesh is judged.
#pragma once

#include <optional>

#include "sim/world/world.h"
#include "tools/evaluation/reconstruction.h"
#include "tools/mission/figures.h"
#include "tools/replay/replay.h"

namespace arpent::tools {

/// The place of a mission, and who was there.
struct MissionSetting {
  std::string name;  ///< of the mission: what its figures begin with
  sim::World world;
  RobotConfig robot;
  RigConfig rig;
  ReplayConfig replay;
  Pose2 start;  ///< true

  [[nodiscard]] double voxel_m() const { return replay.mapping.tsdf.voxel_m; }
};

/// That of a mission that was just run.
[[nodiscard]] MissionSetting setting_of(const MissionSpec& spec, const MissionResult& result);

struct MissionFolder {
  MissionSetting setting;
  MissionResult result;                               ///< without CPU times and processes, which are in no log
  std::optional<double> collisions, realtime_factor;  ///< as mission.json has them
};

/// Reads `folder`/mission.lcmlog, mesh.ply and mission.json. `world` is a file that takes the place of the log's world;
/// empty: none. Throws InputError that names what is missing.
[[nodiscard]] MissionFolder read_mission_folder(const std::filesystem::path& folder,
                                                const std::filesystem::path& world = {});

/// Where the robot could have got to, and what there was to see; a few seconds.
[[nodiscard]] evaluation::LegalViews legal_views(const MissionSetting& setting);

}  // namespace arpent::tools
