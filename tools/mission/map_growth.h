// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How a mission's map came to be: depth images and poses of its log fused once more, with a stop at regular times.
#pragma once

#include <functional>

#include "mapping/surface/incomplete_surface.h"
#include "tools/mission/folder.h"

namespace arpent::tools {

struct MapMoment {
  Time stamp;
  const TriangleMesh& mesh;
  std::size_t incomplete = 0;  ///< incomplete surface elements inside the world's region
};

/// Calls visit(moment) about `moments` times, evenly over the mission, and once more at the end. Depth is fused as
/// mapping_process does it: where a pose of the same time in the map's frame is known and not lost. Returns how many
/// images were fused.
std::int64_t replay_map(const std::filesystem::path& log, const MissionSetting& setting, int moments,
                        const std::function<void(const MapMoment&)>& visit);

}  // namespace arpent::tools
