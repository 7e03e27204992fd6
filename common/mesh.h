// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A triangle mesh (or, with no triangles, a point cloud), and its PLY file.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace arpent {

/// Vertices in metres in the frame the producer states. `normals` is empty or has one unit vector per vertex;
/// `colors_rgb` is empty or has one colour per vertex.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices_m;
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::array<std::uint8_t, 3>> colors_rgb;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Writes binary little-endian PLY through atomic_write (all of it or nothing). Throws InputError if the disk refuses.
void write_ply(const std::filesystem::path& path, const TriangleMesh& mesh);
/// Reads ASCII or binary PLY (either byte order), meshes (polygons are fanned) or point clouds; unknown elements and
/// properties are skipped. Throws InputError with the file's name and the fault if it is damaged.
[[nodiscard]] TriangleMesh read_ply(const std::filesystem::path& path);

}  // namespace arpent
