// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#include "common/error.h"
#include "sim/world/mesh_file.h"
#include "sim/world/node_reader.h"
#include "sim/world/pattern.h"
#include "sim/world/world.h"
#include "sim/world/world_check.h"

namespace arpent::sim {
namespace {

using Eigen::Vector3d;
using Textures = std::map<std::string, std::size_t>;

Region read_region(const YAML::Node& node, const std::string& what, Faults& faults) {
  NodeReader reader(node, what, faults);
  Region region;
  const bool given = reader.vector("min_m", region.min_m, true) & reader.vector("max_m", region.max_m, true);
  if (given && (region.min_m.array() >= region.max_m.array()).any()) reader.fault("max_m must be above min_m");
  reader.finish();
  return region;
}

TextureSpec read_texture(const std::string& name, const YAML::Node& node, Faults& faults) {
  NodeReader reader(node, "texture " + name, faults);
  TextureSpec texture;
  texture.name = name;
  if (reader.text("kind", texture.kind, true)) {
    const auto kinds = pattern_kinds();
    if (std::find(kinds.begin(), kinds.end(), texture.kind) == kinds.end()) {
      reader.fault(fmt::format("kind = {}, must be one of {}", texture.kind, fmt::join(kinds, ", ")));
    }
  }
  reader.number("mean", texture.mean, Sign::kNotNegative);
  reader.number("contrast", texture.contrast, Sign::kNotNegative);
  reader.number("stains", texture.stains, Sign::kNotNegative);
  reader.number("tile_m", texture.tile_m, Sign::kPositive);
  reader.whole("seed", texture.seed);
  if (texture.mean > 1) reader.fault(fmt::format("mean = {}, must be a reflectance between 0 and 1", texture.mean));
  reader.finish();
  return texture;
}

PlaneShape read_plane(NodeReader& reader) {
  PlaneShape plane{Vector3d::Zero(), Vector3d::UnitX(), Vector3d::UnitY()};
  const bool given = reader.vector("corner_m", plane.corner_m, true) & reader.vector("u_m", plane.u_m, true) &
                     reader.vector("v_m", plane.v_m, true);
  if (given && plane.u_m.cross(plane.v_m).norm() < 1e-6) reader.fault("u_m and v_m must span an area");
  return plane;
}

BoxShape read_box(NodeReader& reader) {
  BoxShape box{Vector3d::Zero(), Vector3d::Ones(), 0};
  reader.vector("centre_m", box.centre_m, true);
  if (reader.vector("size_m", box.size_m, true) && (box.size_m.array() <= 0).any()) reader.fault("size_m must be > 0");
  reader.number("yaw_rad", box.yaw_rad);
  return box;
}

CylinderShape read_cylinder(NodeReader& reader) {
  CylinderShape cylinder{Vector3d::Zero()};
  reader.vector("base_m", cylinder.base_m, true);
  reader.number("radius_m", cylinder.radius_m, Sign::kPositive, true);
  reader.number("height_m", cylinder.height_m, Sign::kPositive, true);
  return cylinder;
}

MeshShape read_mesh(NodeReader& reader, Faults& faults) {
  MeshShape mesh;
  const bool given = reader.text("file", mesh.file, true) & !mesh.file.empty();
  bool sound = true;
  if (reader.has("scale")) sound = reader.number("scale", mesh.scale, Sign::kPositive);
  reader.vector("translation_m", mesh.translation_m);
  reader.number("yaw_rad", mesh.yaw_rad);
  if (!given || !sound) return mesh;
  try {
    mesh.data = load_mesh(mesh);
  } catch (const InputError& error) {
    faults.add(reader.line(), error.what());
  }
  return mesh;
}

WorldSurface read_surface(const YAML::Node& node, const Textures& textures, Faults& faults) {
  // One key names the shape: `- box: {…}`.
  const bool named = node.IsMap() && node.size() == 1 && node.begin()->first.IsScalar();
  const std::string kind = named ? node.begin()->first.Scalar() : "";
  WorldSurface surface{PlaneShape{}, 0, 0};
  if (kind != "plane" && kind != "box" && kind != "cylinder" && kind != "mesh") {
    faults.add(node.Mark().line + 1, "a surface must be one of plane, box, cylinder, mesh: {…}");
    return surface;
  }
  NodeReader reader(node.begin()->second, kind, faults);
  if (kind == "plane") surface.shape = read_plane(reader);
  if (kind == "box") surface.shape = read_box(reader);
  if (kind == "cylinder") surface.shape = read_cylinder(reader);
  if (kind == "mesh") surface.shape = read_mesh(reader, faults);
  std::string texture;
  if (reader.text("texture", texture, true)) {
    const auto found = textures.find(texture);
    if (found == textures.end()) reader.fault("there is no texture " + texture);
    if (found != textures.end()) surface.texture = found->second;
  }
  reader.number("glow", surface.glow, Sign::kNotNegative);
  reader.finish();
  return surface;
}

Lamp read_lamp(const YAML::Node& node, Faults& faults) {
  NodeReader reader(node, "lamp", faults);
  Lamp lamp{Vector3d::Zero()};
  reader.vector("position_m", lamp.position_m, true);
  reader.number("intensity", lamp.intensity, Sign::kPositive);
  if (reader.vector("size_m", lamp.size_m) && (lamp.size_m.array() < 0).any()) reader.fault("size_m must be >= 0");
  reader.vector("direction", lamp.direction);
  reader.number("focus", lamp.focus, Sign::kNotNegative);
  reader.finish();
  return lamp;
}

/// The items of a list; complains if it is none.
std::vector<YAML::Node> items(NodeReader& reader, const std::string& key, bool required = false) {
  const YAML::Node list = reader.child(key, required);
  std::vector<YAML::Node> nodes;
  if (list.IsDefined() && !list.IsSequence() && !list.IsNull()) reader.fault(key + " must be a list");
  if (list.IsDefined() && list.IsSequence()) {
    for (const auto& item : list) nodes.push_back(item);
  }
  return nodes;
}

Lighting read_lighting(const YAML::Node& node, Faults& faults) {
  NodeReader reader(node, "lighting", faults);
  Lighting lighting;
  reader.number("ambient", lighting.ambient, Sign::kNotNegative);
  reader.number("sky", lighting.sky, Sign::kNotNegative);
  reader.number("mean", lighting.mean, Sign::kPositive);
  for (const YAML::Node& lamp : items(reader, "lamps")) lighting.lamps.push_back(read_lamp(lamp, faults));
  if (lighting.lamps.empty() && lighting.ambient <= 0) reader.fault("a world needs a lamp or ambient light");
  reader.finish();
  return lighting;
}

TagCube read_tag_cube(const YAML::Node& node, Faults& faults) {
  NodeReader reader(node, "tag_cube", faults);
  TagCube cube;
  reader.vector("centre_m", cube.centre_m, true);
  reader.number("yaw_rad", cube.yaw_rad);
  reader.number("edge_m", cube.edge_m, Sign::kPositive);
  reader.number("tag_m", cube.tag_m, Sign::kPositive);
  reader.number("stand_m", cube.stand_m, Sign::kPositive);
  std::vector<double> ids;
  if (reader.numbers("ids", ids, 4)) {
    for (std::size_t k = 0; k < 4; ++k) {
      cube.ids[k] = static_cast<int>(ids[k]);
      if (ids[k] != cube.ids[k] || ids[k] < 0 || ids[k] >= tag_count()) {
        reader.fault(fmt::format("ids must be tags of 36h11, 0 to {}", tag_count() - 1));
      }
    }
  }
  // The picture of a tag has ten cells, eight of them within the border.
  if (std::abs(cube.tag_m / cube.edge_m - 0.8) > 1e-9) reader.fault("tag_m must be 0.8 edge_m");
  reader.finish();
  return cube;
}

void read_starts(NodeReader& root, World& world, std::vector<int>& lines, Faults& faults) {
  for (const YAML::Node& node : items(root, "starts", true)) {
    NodeReader reader(node, "start", faults);
    Pose2 start;
    if (reader.number("x_m", start.x_m, Sign::kAny, true) & reader.number("y_m", start.y_m, Sign::kAny, true) &
        reader.number("yaw_rad", start.yaw_rad, Sign::kAny, true)) {
      world.starts.push_back(start);
      lines.push_back(reader.line());
    }
    reader.finish();
  }
}

World read_world(const YAML::Node& document, Faults& faults) {
  NodeReader root(document, "world", faults);
  World world;
  root.text("name", world.name, true);
  if (const auto node = root.child("region", true); node.IsDefined())
    world.region = read_region(node, "region", faults);
  for (const YAML::Node& node : items(root, "excluded"))
    world.excluded.push_back(read_region(node, "excluded", faults));
  Textures textures;
  if (const auto node = root.child("textures", true); node.IsDefined() && node.IsMap()) {
    for (const auto& item : node) {
      const std::string name = item.first.Scalar();
      if (!textures.emplace(name, textures.size()).second) root.fault("texture " + name + " is given twice");
      world.textures.push_back(read_texture(name, item.second, faults));
    }
  }
  for (const YAML::Node& node : items(root, "surfaces", true)) {
    world.surfaces.push_back(read_surface(node, textures, faults));
  }
  if (const auto node = root.child("lighting", true); node.IsDefined()) world.lighting = read_lighting(node, faults);
  if (const auto node = root.child("tag_cube"); node.IsDefined()) world.tag_cube = read_tag_cube(node, faults);
  std::vector<int> start_lines;
  read_starts(root, world, start_lines, faults);
  root.finish();
  if (faults.empty()) check_world(world, start_lines, faults);
  return world;
}

std::string list(const Vector3d& v) {
  return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

std::string shape_yaml(const Shape& shape) {
  if (const auto* plane = std::get_if<PlaneShape>(&shape)) {
    return fmt::format("plane: {{corner_m: {}, u_m: {}, v_m: {}", list(plane->corner_m), list(plane->u_m),
                       list(plane->v_m));
  }
  if (const auto* box = std::get_if<BoxShape>(&shape)) {
    return fmt::format("box: {{centre_m: {}, size_m: {}, yaw_rad: {}", list(box->centre_m), list(box->size_m),
                       box->yaw_rad);
  }
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) {
    return fmt::format("cylinder: {{base_m: {}, radius_m: {}, height_m: {}", list(cylinder->base_m), cylinder->radius_m,
                       cylinder->height_m);
  }
  const auto& mesh = std::get<MeshShape>(shape);
  return fmt::format("mesh: {{file: \"{}\", scale: {}, translation_m: {}, yaw_rad: {}", mesh.file, mesh.scale,
                     list(mesh.translation_m), mesh.yaw_rad);
}

std::string lighting_yaml(const Lighting& lighting) {
  std::string text = fmt::format("lighting:\n  ambient: {}\n  sky: {}\n  mean: {}\n  lamps:\n", lighting.ambient,
                                 lighting.sky, lighting.mean);
  for (const Lamp& lamp : lighting.lamps) {
    text += fmt::format("    - {{position_m: {}, intensity: {}, size_m: {}, direction: {}, focus: {}}}\n",
                        list(lamp.position_m), lamp.intensity, list(lamp.size_m), list(lamp.direction), lamp.focus);
  }
  return text;
}

}  // namespace

World parse_world(const std::string& yaml, const std::string& name) {
  Faults faults(name);
  World world;
  try {
    world = read_world(YAML::Load(yaml), faults);
  } catch (const YAML::Exception& error) {
    faults.add(error.mark.line + 1, "not valid YAML: " + error.msg);
  }
  faults.throw_if_any();
  return world;
}

World load_world(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  if (std::filesystem::is_directory(file) || !in || !(text << in.rdbuf())) {
    throw InputError("cannot read the world file " + file.string());
  }
  return parse_world(text.str(), file.string());
}

Pose2 start_of(const World& world, int start) {
  if (start < 0 || static_cast<std::size_t>(start) >= world.starts.size()) {
    throw InputError(
        fmt::format("world {} has {} starts; there is no start {}", world.name, world.starts.size(), start));
  }
  return world.starts[static_cast<std::size_t>(start)];
}

std::string to_yaml(const World& world) {
  std::string text = fmt::format("name: \"{}\"\nregion: {{min_m: {}, max_m: {}}}\n", world.name,
                                 list(world.region.min_m), list(world.region.max_m));
  if (!world.excluded.empty()) text += "excluded:\n";
  for (const Region& region : world.excluded) {
    text += fmt::format("  - {{min_m: {}, max_m: {}}}\n", list(region.min_m), list(region.max_m));
  }
  text += "textures:\n";
  for (const TextureSpec& texture : world.textures) {
    text += fmt::format("  {}: {{kind: {}, mean: {}, contrast: {}, stains: {}, tile_m: {}, seed: {}}}\n", texture.name,
                        texture.kind, texture.mean, texture.contrast, texture.stains, texture.tile_m, texture.seed);
  }
  text += "surfaces:\n";
  for (const WorldSurface& surface : world.surfaces) {
    text += fmt::format("  - {}, texture: {}, glow: {}}}\n", shape_yaml(surface.shape),
                        world.textures[surface.texture].name, surface.glow);
  }
  text += lighting_yaml(world.lighting);
  if (world.tag_cube) {
    const TagCube& cube = *world.tag_cube;
    text += fmt::format("tag_cube: {{centre_m: {}, yaw_rad: {}, edge_m: {}, tag_m: {}, ids: [{}], stand_m: {}}}\n",
                        list(cube.centre_m), cube.yaw_rad, cube.edge_m, cube.tag_m, fmt::join(cube.ids, ", "),
                        cube.stand_m);
  }
  text += "starts:\n";
  for (const Pose2& start : world.starts) {
    text += fmt::format("  - {{x_m: {}, y_m: {}, yaw_rad: {}}}\n", start.x_m, start.y_m, start.yaw_rad);
  }
  return text;
}

}  // namespace arpent::sim
