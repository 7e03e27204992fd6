// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The map on disk: blocks quantised (distance to 1/2047 of the truncation distance, weight to 1/8 octave, whether a
// voxel is known kept exactly), compressed in groups with zstd, each block with a CRC-32C, written whole or not at all.
// A damaged file gives back every block whose group and checksum are intact.
#pragma once

#include <filesystem>
#include <string>

#include "mapping/tsdf/tsdf_map.h"

namespace arpent::mapping {

/// Throws InputError if the disk refuses; what was at `path` stays then.
void save_map(const std::filesystem::path& path, const TsdfMap& map);

struct LoadedMap {
  TsdfMap map;
  std::size_t lost_blocks = 0;  ///< of those that the file should hold
  std::string report;           ///< empty if all is well
};
/// Throws InputError if the file is not there, is no map, or its header is damaged.
[[nodiscard]] LoadedMap load_map(const std::filesystem::path& path);

}  // namespace arpent::mapping
