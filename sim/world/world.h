// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A simulated place as a plain value: surfaces with textures, lamps, the robots' starts, the tag cube, the region that
// counts. Read from YAML (docs/worlds.md is the schema), written to YAML, checked as a whole. The cameras (sim/camera)
// and the ground checks (ground.h) are built from it; nothing here renders.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/mesh.h"
#include "common/pose2.h"
#include "sim/world/tag_cube.h"

namespace arpent::sim {

/// What a surface is made of. `kind` chooses the pattern (pattern.h); the reflectance is `mean + contrast * pattern`,
/// where the pattern has zero mean and unit deviation, kept within [0.02, 0.95]. `stains`: relative deviation of slow
/// changes of brightness over metres. Patterns repeat every `tile_m`.
struct TextureSpec {
  std::string name;
  std::string kind = "plain";
  double mean = 0.45;
  double contrast = 0.05;
  double stains = 0.05;
  double tile_m = 2;
  int seed = 1;
};

/// The parallelogram corner + a u + b v, a and b in [0, 1]; its normal u x v looks into free space.
struct PlaneShape {
  Eigen::Vector3d corner_m;
  Eigen::Vector3d u_m;
  Eigen::Vector3d v_m;
};

/// A solid box with a vertical axis.
struct BoxShape {
  Eigen::Vector3d centre_m;
  Eigen::Vector3d size_m;
  double yaw_rad = 0;
};

/// A solid vertical cylinder; `base_m` is the centre of its lower disc. It is a prism of 64 sides, everywhere.
struct CylinderShape {
  Eigen::Vector3d base_m;
  double radius_m = 0.3;
  double height_m = 2;
};

/// A picture on a mesh, reflectance 0..255.
struct MeshPicture {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> values;
};

/// A mesh as loaded, already scaled, turned and moved into the world.
struct MeshData {
  TriangleMesh mesh;
  std::vector<std::array<Eigen::Vector2f, 3>> picture_uv;  ///< of each triangle, v up
  std::vector<int> picture_of_triangle;                    ///< -1: none
  std::vector<float> reflectance_of_triangle;              ///< mean reflectance where there is no picture
  std::vector<MeshPicture> pictures;
};

/// A mesh file; `data` is shared because worlds are copied and meshes are large, and never changed.
struct MeshShape {
  std::string file;  ///< as written; under $ARPENT_DATA/worlds unless absolute
  double scale = 1;
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
  double yaw_rad = 0;
  std::shared_ptr<const MeshData> data;
};

using Shape = std::variant<PlaneShape, BoxShape, CylinderShape, MeshShape>;

/// `glow`: light that the surface sends out by itself, in the units of reflected light (1: a white sheet in mean
/// light).
struct WorldSurface {
  Shape shape;
  std::size_t texture = 0;  ///< index into World::textures
  double glow = 0;
};

/// A lamp: the light at a point falls off with the square of the distance and with cos^focus of the angle off
/// `direction` (a zero direction: equal to all sides). `size_m`: a box around the position that shines as a whole, so
/// that shadows are soft.
struct Lamp {
  Eigen::Vector3d position_m;
  double intensity = 1;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  double focus = 1;
};

/// `ambient`: light from everywhere, relative to intensity 1 at 1 m. All light is scaled so that the surfaces' mean
/// irradiance is `mean`; at 1 and the nominal exposure a reflectance of 0.45 gives level 115. `sky`: what a ray into
/// the void sees.
struct Lighting {
  double ambient = 0.02;
  double sky = 0.015;
  double mean = 1;
  std::vector<Lamp> lamps;
};

/// An axis-aligned box.
struct Region {
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d max_m = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::AlignedBox3d box_m() const { return {min_m, max_m}; }
  [[nodiscard]] bool contains(const Eigen::Vector3d& p_world_m) const {
    return (p_world_m.array() >= min_m.array()).all() && (p_world_m.array() <= max_m.array()).all();
  }
};

struct World {
  std::string name;
  Region region;                 ///< what is to be reconstructed and evaluated
  std::vector<Region> excluded;  ///< left out of the evaluation, beside the tag cube
  std::vector<TextureSpec> textures;
  std::vector<WorldSurface> surfaces;
  Lighting lighting;
  std::vector<Pose2> starts;
  std::optional<TagCube> tag_cube;
};

/// Reads and checks a world. Throws InputError that lists every fault as `file:line: …`: unknown or missing keys,
/// values that are no finite numbers, textures and meshes that are not there, starts in an obstacle, outside the region
/// or into each other (footprint of the thesis, 0.55 x 0.25 m).
[[nodiscard]] World load_world(const std::filesystem::path& file);
/// The same from text; `name` stands for the file in messages.
[[nodiscard]] World parse_world(const std::string& yaml, const std::string& name);
/// The YAML that load_world reads back into the same world.
[[nodiscard]] std::string to_yaml(const World& world);
/// A start by its number, from 0. Throws InputError that says how many there are.
[[nodiscard]] Pose2 start_of(const World& world, int start);

/// The surface that counts, as triangles with normals towards free space: inside the region, without the excluded
/// parts, the tag cube, and what touches another solid or the region's border from outside (the floor under a box, the
/// top of a pillar below the ceiling).
[[nodiscard]] TriangleMesh truth_mesh(const World& world);

}  // namespace arpent::sim
