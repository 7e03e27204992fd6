// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/random_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/error.h"
#include "sim/world/ground.h"
#include "sim/world/noise.h"

namespace arpent::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kClearanceM = 0.8;  ///< of starts and the cube (DESIGN section 4)
constexpr double kPassageM = 0.7;    ///< narrowest passage that counts as one
constexpr double kGridM = 0.2;       ///< of the search for closed-off floor
constexpr std::size_t kMostStarts = 8;

class Dice {
 public:
  explicit Dice(std::uint32_t seed) : seed_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(uniform_of(seed_, next_++));
  }
  int whole(int low, int high) { return std::min(high, static_cast<int>(std::floor(between(low, high + 1)))); }

 private:
  std::uint32_t seed_;
  std::uint32_t next_ = 0;
};

/// Two decimals: worlds are read by people.
double tidy(double x) {
  return std::round(100 * x) / 100;
}

std::size_t add_texture(World& world, Dice& dice, const std::string& name, const std::vector<std::string>& kinds) {
  TextureSpec texture;
  texture.name = name;
  texture.kind = kinds[static_cast<std::size_t>(dice.whole(0, static_cast<int>(kinds.size()) - 1))];
  texture.mean = tidy(dice.between(0.25, 0.60));
  // From nearly blank to rich.
  texture.contrast = std::round(1000 * texture.mean * dice.between(0.05, 0.24)) / 1000;
  texture.stains = tidy(dice.between(0.02, 0.10));
  texture.tile_m = tidy(dice.between(1.5, 3.0));
  texture.seed = dice.whole(1, 1000000);
  world.textures.push_back(texture);
  return world.textures.size() - 1;
}

void add_room(World& world, Dice& dice) {
  const Vector3d& size = world.region.max_m;
  const double x = size.x(), y = size.y(), z = size.z();
  const auto floor = add_texture(world, dice, "floor", {"asphalt", "concrete", "rubber", "wood", "bricks"});
  const auto wall_a = add_texture(world, dice, "walls_a", {"concrete", "plaster", "mat", "bricks"});
  const auto wall_b = add_texture(world, dice, "walls_b", {"concrete", "plaster", "mat", "metal", "wood"});
  world.surfaces.push_back({PlaneShape{{0, 0, 0}, {x, 0, 0}, {0, y, 0}}, floor, 0});
  world.surfaces.push_back({PlaneShape{{x, 0, 0}, {-x, 0, 0}, {0, 0, z}}, wall_a, 0});
  world.surfaces.push_back({PlaneShape{{0, y, 0}, {x, 0, 0}, {0, 0, z}}, wall_a, 0});
  world.surfaces.push_back({PlaneShape{{0, 0, 0}, {0, y, 0}, {0, 0, z}}, wall_b, 0});
  world.surfaces.push_back({PlaneShape{{x, y, 0}, {0, -y, 0}, {0, 0, z}}, wall_b, 0});
  if (dice.between(0, 1) < 0.6) {
    const auto ceiling = add_texture(world, dice, "ceiling", {"plaster", "concrete", "metal"});
    world.surfaces.push_back({PlaneShape{{0, y, z}, {x, 0, 0}, {0, -y, 0}}, ceiling, 0});
  }
}

void add_obstacles(World& world, Dice& dice) {
  const Vector3d& size = world.region.max_m;
  const auto pillars = add_texture(world, dice, "pillars", {"concrete", "plaster", "metal", "stone"});
  const auto boxes = add_texture(world, dice, "boxes", {"carton", "wood", "metal"});
  const auto crates = add_texture(world, dice, "crates", {"carton", "wood", "fabric"});
  const auto partitions = add_texture(world, dice, "partitions", {"plaster", "bricks", "wood", "concrete"});
  const auto inside = [&](double margin) {
    return Vector2d(tidy(dice.between(margin, size.x() - margin)), tidy(dice.between(margin, size.y() - margin)));
  };
  for (int i = dice.whole(0, 3); i > 0; --i) {
    const Vector2d p = inside(1.2);
    const double width = tidy(dice.between(0.3, 0.8));
    if (dice.between(0, 1) < 0.5) {
      world.surfaces.push_back({CylinderShape{{p.x(), p.y(), 0}, 0.5 * width, size.z()}, pillars, 0});
    } else {
      world.surfaces.push_back({BoxShape{{p.x(), p.y(), 0.5 * size.z()}, {width, width, size.z()}, 0}, pillars, 0});
    }
  }
  for (int i = dice.whole(0, 2); i > 0; --i) {
    // From a wall into the room, up to two thirds of its width.
    const bool along_x = dice.between(0, 1) < 0.5, from_far = dice.between(0, 1) < 0.5;
    const double across = along_x ? size.x() : size.y(), length = tidy(dice.between(0.25, 0.6) * across);
    const double middle = from_far ? across - 0.5 * length : 0.5 * length;
    const double at = tidy(dice.between(0.3, 0.7) * (along_x ? size.y() : size.x()));
    const Vector3d centre = along_x ? Vector3d(middle, at, 0.5 * size.z()) : Vector3d(at, middle, 0.5 * size.z());
    const Vector3d extent = along_x ? Vector3d(length, 0.15, size.z()) : Vector3d(0.15, length, size.z());
    world.surfaces.push_back({BoxShape{centre, extent, 0}, partitions, 0});
  }
  const double floor_m2 = size.x() * size.y();
  for (int i = static_cast<int>(floor_m2 * dice.between(0.02, 0.05)); i > 0; --i) {
    const Vector2d p = inside(0.8);
    const Vector3d extent(tidy(dice.between(0.4, 2.0)), tidy(dice.between(0.4, 1.0)), tidy(dice.between(0.3, 1.2)));
    const BoxShape box{{p.x(), p.y(), 0.5 * extent.z()}, extent, tidy(dice.between(-1.57, 1.57))};
    world.surfaces.push_back({box, dice.between(0, 1) < 0.5 ? boxes : crates, 0});
  }
}

void add_lamps(World& world, Dice& dice) {
  const Vector3d& size = world.region.max_m;
  const int columns = std::max(1, static_cast<int>(size.x() / dice.between(3.0, 6.0)));
  const int rows = std::max(1, static_cast<int>(size.y() / dice.between(3.0, 6.0)));
  for (int i = 0; i < columns * rows; ++i) {
    Lamp lamp;
    lamp.position_m = Vector3d(tidy((i % columns + dice.between(0.3, 0.7)) * size.x() / columns),
                               tidy((i / columns + dice.between(0.3, 0.7)) * size.y() / rows), tidy(size.z() - 0.1));
    lamp.intensity = tidy(dice.between(0.3, 1.0));
    lamp.size_m = Vector3d(tidy(dice.between(0.2, 2.0)), 0.15, 0);
    if (dice.between(0, 1) > 0.15) world.lighting.lamps.push_back(lamp);  // some are broken
  }
  world.lighting.ambient = tidy(dice.between(0.01, 0.06));
  world.lighting.mean = tidy(dice.between(0.7, 1.2));
}

/// Can a robot get from anywhere on the free floor to anywhere else?
bool in_one_piece(const GroundMap& ground, const Vector3d& size) {
  const int columns = static_cast<int>(size.x() / kGridM), rows = static_cast<int>(size.y() / kGridM);
  std::vector<int> open;
  std::vector<char> free(static_cast<std::size_t>(columns * rows));
  for (int i = 0; i < columns * rows; ++i) {
    const Vector2d p((i % columns + 0.5) * kGridM, (i / columns + 0.5) * kGridM);
    free[static_cast<std::size_t>(i)] = ground.distance_m(p) > 0.5 * kPassageM ? 1 : 0;
  }
  const auto first = std::find(free.begin(), free.end(), 1);
  if (first == free.end()) return false;
  open.push_back(static_cast<int>(first - free.begin()));
  free[static_cast<std::size_t>(open.front())] = 0;
  while (!open.empty()) {
    const int i = open.back();
    open.pop_back();
    for (const auto& [du, dv] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const int u = i % columns + du, v = i / columns + dv, k = v * columns + u;
      if (u < 0 || v < 0 || u >= columns || v >= rows || free[static_cast<std::size_t>(k)] == 0) continue;
      free[static_cast<std::size_t>(k)] = 0;
      open.push_back(k);
    }
  }
  return std::count(free.begin(), free.end(), 1) == 0;
}

bool clear_view(const GroundMap& ground, const Vector2d& from, const Vector2d& to) {
  for (int i = 0; i <= 20; ++i) {
    if (ground.distance_m(from + i / 20.0 * (to - from)) < 0.1) return false;
  }
  return true;
}

/// Starts on a ring around the cube, as many as fit.
void add_starts(World& world, const GroundMap& ground, Dice& dice, const Vector2d& cube) {
  for (int attempt = 0; attempt < 200 && world.starts.size() < kMostStarts; ++attempt) {
    const double angle = dice.between(-std::numbers::pi, std::numbers::pi), distance = dice.between(1.2, 2.0);
    Pose2 start{tidy(cube.x() - distance * std::cos(angle)), tidy(cube.y() - distance * std::sin(angle)), tidy(angle)};
    // Clear of the walls, of each other by 0.1 m, and of the cube by the ring.
    const EllipseFootprint wide{0.65, 0.35};
    const bool apart = std::none_of(world.starts.begin(), world.starts.end(),
                                    [&](const Pose2& other) { return overlap(start, wide, other, wide); });
    const Vector2d p = start.position_m();
    const bool in_room = world.region.contains({p.x(), p.y(), 1e-3});
    if (in_room && apart && ground.distance_m(p) >= kClearanceM && clear_view(ground, p, cube)) {
      world.starts.push_back(start);
    }
  }
}

/// Puts the cube and the starts somewhere; false if there is no room for two robots.
bool furnish(World& world, Dice& dice) {
  const GroundMap ground(world);
  if (!in_one_piece(ground, world.region.max_m)) return false;
  for (int attempt = 0; attempt < 100; ++attempt) {
    const Vector2d cube(tidy(dice.between(1, world.region.max_m.x() - 1)),
                        tidy(dice.between(1, world.region.max_m.y() - 1)));
    if (ground.distance_m(cube) < kClearanceM) continue;
    world.starts.clear();
    add_starts(world, ground, dice, cube);
    if (world.starts.size() < 2) continue;
    world.tag_cube = TagCube{};
    world.tag_cube->centre_m = Vector3d(cube.x(), cube.y(), 0.40);
    return true;
  }
  return false;
}

}  // namespace

World make_random_world(std::uint32_t seed) {
  for (std::uint32_t attempt = 0; attempt < 1000; ++attempt) {
    Dice dice(hash_bits(seed, attempt));
    World world;
    world.name = fmt::format("random_{}", seed);
    world.region.max_m = Vector3d(tidy(dice.between(6, 16)), tidy(dice.between(5, 12)), tidy(dice.between(2, 3)));
    add_room(world, dice);
    add_obstacles(world, dice);
    add_lamps(world, dice);
    if (!world.lighting.lamps.empty() && furnish(world, dice)) return world;
  }
  throw InputError(fmt::format("seed {} draws no world with room for two robots", seed));
}

}  // namespace arpent::sim
