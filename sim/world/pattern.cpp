// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/pattern.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "common/error.h"
#include "sim/world/noise.h"

namespace arpent::sim {
namespace {

/// A tile under construction; indices wrap around.
struct Tile {
  int side;
  double texels_per_m;
  std::uint32_t seed;
  std::vector<float> values;

  Tile(int side_, double tile_m, std::uint32_t seed_)
      : side(side_),
        texels_per_m(side_ / tile_m),
        seed(seed_),
        values(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), 0.0F) {}

  float& at(int u, int v) {
    return values[static_cast<std::size_t>(v & (side - 1)) * static_cast<std::size_t>(side) +
                  static_cast<std::size_t>(u & (side - 1))];
  }
  /// One random number per `key`, in [0, 1).
  [[nodiscard]] float random(std::uint32_t key) const { return uniform_of(seed, key); }
  /// Joints and boards must fit the tile a whole number of times.
  [[nodiscard]] int cells_of(double size_m) const {
    return std::max(1, static_cast<int>(std::lround(side / (size_m * texels_per_m))));
  }
};

/// A grid of nu x nv random numbers, enlarged to the tile by cubic B-splines (smooth, periodic).
void add_layer(Tile& tile, int nu, int nv, float amplitude, std::uint32_t salt) {
  const auto weights = [&](int n) {
    std::vector<std::array<float, 4>> all(static_cast<std::size_t>(tile.side));
    for (int i = 0; i < tile.side; ++i) {
      const float x = static_cast<float>(i) * static_cast<float>(n) / static_cast<float>(tile.side);
      const float t = x - std::floor(x), s = 1 - t;
      all[static_cast<std::size_t>(i)] = {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                                          (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6};
    }
    return all;
  };
  const auto wu = weights(nu), wv = weights(nv);
  std::vector<float> rows(static_cast<std::size_t>(nv) * static_cast<std::size_t>(tile.side));
  for (int j = 0; j < nv; ++j) {
    for (int u = 0; u < tile.side; ++u) {
      const int base = u * nu / tile.side - 1 + nu;
      float sum = 0;
      for (int k = 0; k < 4; ++k) {
        const auto key = static_cast<std::uint32_t>(j * nu + (base + k) % nu);
        sum += wu[static_cast<std::size_t>(u)][static_cast<std::size_t>(k)] * gaussian_of(tile.seed ^ salt, key);
      }
      rows[static_cast<std::size_t>(j) * static_cast<std::size_t>(tile.side) + static_cast<std::size_t>(u)] = sum;
    }
  }
  for (int v = 0; v < tile.side; ++v) {
    const int base = v * nv / tile.side - 1 + nv;
    for (int k = 0; k < 4; ++k) {
      const float w = amplitude * wv[static_cast<std::size_t>(v)][static_cast<std::size_t>(k)];
      const float* row = &rows[static_cast<std::size_t>((base + k) % nv) * static_cast<std::size_t>(tile.side)];
      float* out = &tile.values[static_cast<std::size_t>(v) * static_cast<std::size_t>(tile.side)];
      for (int u = 0; u < tile.side; ++u) out[u] += w * row[u];
    }
  }
}

/// Octaves from `first` grid cells on, each `gain` times as strong as the one before. `stretch`: cells longer along u.
void add_fractal(Tile& tile, int first, float gain, float amplitude = 1, int stretch = 1) {
  std::uint32_t salt = 0x1000;
  for (int n = first; n <= tile.side / 2; n *= 2, amplitude *= gain) {
    add_layer(tile, std::max(4, n / stretch), n, amplitude, salt += 0x51);
  }
}

/// Independent noise of each texel.
void add_grain(Tile& tile, float amplitude) {
  for (std::size_t i = 0; i < tile.values.size(); ++i) {
    tile.values[i] += amplitude * gaussian_of(tile.seed ^ 0xABCDU, static_cast<std::uint32_t>(i));
  }
}

/// `count` soft round spots of random size in [least_m, most_m] and strength around `strength`.
void add_spots(Tile& tile, int count, double least_m, double most_m, float strength, float spread) {
  for (int i = 0; i < count; ++i) {
    const auto key = static_cast<std::uint32_t>(i) * 8 + 0x77000000U;
    const float cu = tile.random(key) * static_cast<float>(tile.side);
    const float cv = tile.random(key + 1) * static_cast<float>(tile.side);
    const float size = tile.random(key + 2);
    // Small spots are more frequent than large ones.
    const double radius =
        0.5 * tile.texels_per_m * (least_m + (most_m - least_m) * static_cast<double>(size * size * size));
    const float level = strength + spread * (2 * tile.random(key + 3) - 1);
    const int reach = static_cast<int>(std::ceil(radius + 1));
    for (int dv = -reach; dv <= reach; ++dv) {
      for (int du = -reach; du <= reach; ++du) {
        const float u = std::floor(cu) + static_cast<float>(du), v = std::floor(cv) + static_cast<float>(dv);
        const float distance = std::hypot(u - cu, v - cv);
        const float cover = std::clamp(static_cast<float>(radius) - distance + 0.5F, 0.0F, 1.0F);
        tile.at(static_cast<int>(u), static_cast<int>(v)) += cover * level;
      }
    }
  }
}

void add_rectangle(Tile& tile, int u0, int v0, int width, int height, float level) {
  for (int v = v0; v < v0 + height; ++v) {
    for (int u = u0; u < u0 + width; ++u) tile.at(u, v) += level;
  }
}

/// A joint of the given width along u at row v0 (or along v at column u0).
void add_joint(Tile& tile, bool along_u, int at, double width_m, float level) {
  const int width = std::max(1, static_cast<int>(std::lround(width_m * tile.texels_per_m)));
  if (along_u) {
    add_rectangle(tile, 0, at, tile.side, width, level);
  } else {
    add_rectangle(tile, at, 0, width, tile.side, level);
  }
}

void concrete(Tile& tile) {
  add_fractal(tile, 4, 0.80F);
  add_spots(tile, static_cast<int>(900 * std::pow(tile.side / tile.texels_per_m / 2, 2)), 0.003, 0.03, -1.6F, 0.8F);
}

void asphalt(Tile& tile) {
  add_fractal(tile, 8, 0.97F);
  add_spots(tile, static_cast<int>(5000 * std::pow(tile.side / tile.texels_per_m / 2, 2)), 0.004, 0.016, 0.4F, 2.4F);
  add_grain(tile, 0.4F);
}

void plaster(Tile& tile) {
  add_fractal(tile, 4, 0.88F);
}

/// Padded gym mats, 1 m wide: a weave, slow folds, seams between the mats with a soft shade on either side.
void mat(Tile& tile) {
  add_fractal(tile, 4, 0.72F, 1.0F);
  add_grain(tile, 0.35F);
  const int mats = tile.cells_of(1.0);
  for (int i = 0; i < mats; ++i) {
    const int seam = i * tile.side / mats;
    add_joint(tile, false, seam, 0.012, -5);
    for (int step = 1; step <= 8; ++step) {
      const int offset = static_cast<int>(std::lround(step * 0.008 * tile.texels_per_m));
      add_joint(tile, false, seam - offset, 0.008, -0.16F * static_cast<float>(9 - step));
      add_joint(tile, false, seam + offset, 0.008, -0.16F * static_cast<float>(9 - step));
    }
    const float shade = 1.6F * (tile.random(0x500U + static_cast<std::uint32_t>(i)) - 0.5F);
    add_rectangle(tile, seam, 0, tile.side / mats, tile.side, shade);
  }
}

/// Boards along u, 0.12 m wide, each of its own brightness, with joints and grain.
void wood(Tile& tile) {
  add_fractal(tile, 16, 0.85F, 0.8F, 8);
  const int boards = tile.cells_of(0.12);
  for (int i = 0; i < boards; ++i) {
    const int top = i * tile.side / boards, bottom = (i + 1) * tile.side / boards;
    const auto key = static_cast<std::uint32_t>(i) + 0x900U;
    const int butt = static_cast<int>(tile.random(key) * static_cast<float>(tile.side));
    add_rectangle(tile, 0, top, tile.side, bottom - top, 1.6F * (tile.random(key + 0x100U) - 0.5F));
    add_rectangle(tile, butt, top, tile.side / 2, bottom - top, 1.4F * (tile.random(key + 0x200U) - 0.5F));
    add_joint(tile, true, top, 0.004, -2.5F);
    add_rectangle(tile, butt, top, std::max(1, tile.side / 512), bottom - top, -2.5F);
  }
  add_spots(tile, 25, 0.01, 0.03, -2.0F, 0.7F);
}

/// Packing paper with printed bars and lines of text, and a strip of tape.
void carton(Tile& tile) {
  add_fractal(tile, 8, 0.75F, 0.25F);
  const int labels = tile.cells_of(0.45);
  const int pitch = tile.side / labels;
  for (int i = 0; i < labels * labels; ++i) {
    const auto key = static_cast<std::uint32_t>(i) * 64 + 0x3000U;
    const int u0 = (i % labels) * pitch + static_cast<int>(0.4F * tile.random(key) * static_cast<float>(pitch));
    const int v0 = (i / labels) * pitch + static_cast<int>(0.4F * tile.random(key + 1) * static_cast<float>(pitch));
    const int width = static_cast<int>((0.25F + 0.3F * tile.random(key + 2)) * static_cast<float>(pitch));
    const int lines = 3 + static_cast<int>(4 * tile.random(key + 3));
    const int line = std::max(2, pitch / 28);
    add_rectangle(tile, u0 - line, v0 - line, width + 2 * line, (2 * lines + 1) * line, 1.3F * tile.random(key + 4));
    for (int l = 0; l < lines; ++l) {
      for (int u = 0; u < width;) {
        const auto word = key + 5 + static_cast<std::uint32_t>(l * 7 + u) % 57;
        const int length = line + static_cast<int>(tile.random(word) * 4 * static_cast<float>(line));
        if (tile.random(word + 1) > 0.25F) add_rectangle(tile, u0 + u, v0 + 2 * l * line, length, line, -2.2F);
        u += length + line / 2 + 1;
      }
    }
  }
  add_joint(tile, true, tile.side / 3, 0.06, 0.6F);
}

/// Brushed sheets with rivets at their joints.
void metal(Tile& tile) {
  add_fractal(tile, 32, 0.9F, 0.5F, 16);
  add_fractal(tile, 4, 0.6F, 0.8F);
  const int sheets = tile.cells_of(0.5);
  for (int i = 0; i < sheets; ++i) {
    add_joint(tile, false, i * tile.side / sheets, 0.005, -2.5F);
    add_joint(tile, true, i * tile.side / sheets, 0.005, -2.5F);
  }
}

/// Bricks of 0.25 x 0.125 m in stretcher bond: repetitive.
void bricks(Tile& tile) {
  add_fractal(tile, 16, 0.9F, 0.35F);
  const int rows = 2 * tile.cells_of(0.25), columns = tile.cells_of(0.25);
  const int joint = std::max(1, static_cast<int>(std::lround(0.010 * tile.texels_per_m)));
  for (int row = 0; row < rows; ++row) {
    const int top = row * tile.side / rows, bottom = (row + 1) * tile.side / rows;
    const int shift = row % 2 == 0 ? 0 : tile.side / columns / 2;
    for (int column = 0; column < columns; ++column) {
      const int left = column * tile.side / columns + shift, right = (column + 1) * tile.side / columns + shift;
      const float shade = 1.4F * (tile.random(static_cast<std::uint32_t>(row * 64 + column) + 0x700U) - 0.5F);
      add_rectangle(tile, left, top, right - left, bottom - top, shade);
      add_rectangle(tile, left, top, joint, bottom - top, 1.6F);
    }
    add_rectangle(tile, 0, top, tile.side, joint, 1.6F);
  }
}

/// Floor covering with bright and dark crumbs.
void rubber(Tile& tile) {
  add_fractal(tile, 8, 0.8F, 0.5F);
  const int count = static_cast<int>(9000 * std::pow(tile.side / tile.texels_per_m / 2, 2));
  add_spots(tile, count, 0.004, 0.022, 0.2F, 2.0F);
}

/// Cloth with folds that run along v.
void fabric(Tile& tile) {
  add_layer(tile, 16, 4, 2.0F, 0x21);
  add_layer(tile, 40, 8, 1.2F, 0x22);
  add_fractal(tile, 32, 0.8F, 0.3F);
  add_grain(tile, 0.2F);
}

/// Weathered copper, rock: coarse and rich.
void stone(Tile& tile) {
  add_fractal(tile, 4, 0.92F);
  for (float& value : tile.values) value = std::abs(value) * 1.2F;
  add_fractal(tile, 32, 0.9F, 0.5F);
}

void plain(Tile& /*tile*/) {}

const std::map<std::string, std::function<void(Tile&)>>& makers() {
  static const std::map<std::string, std::function<void(Tile&)>> all{
      {"plain", plain},   {"concrete", concrete}, {"asphalt", asphalt}, {"plaster", plaster},
      {"mat", mat},       {"wood", wood},         {"carton", carton},   {"metal", metal},
      {"bricks", bricks}, {"rubber", rubber},     {"fabric", fabric},   {"stone", stone}};
  return all;
}

void normalize(std::vector<float>& values) {
  double sum = 0, squares = 0;
  for (const float value : values) sum += static_cast<double>(value);
  const double mean = sum / static_cast<double>(values.size());
  for (const float value : values) squares += (static_cast<double>(value) - mean) * (static_cast<double>(value) - mean);
  const double deviation = std::sqrt(squares / static_cast<double>(values.size()));
  if (deviation < 1e-12) return;
  for (float& value : values) value = static_cast<float>((static_cast<double>(value) - mean) / deviation);
}

}  // namespace

std::vector<std::string> pattern_kinds() {
  std::vector<std::string> kinds;
  for (const auto& [kind, maker] : makers()) kinds.push_back(kind);
  return kinds;
}

std::vector<float> make_pattern(const std::string& kind, int seed, double tile_m, int side) {
  ARPENT_ASSERT(makers().contains(kind) && side >= 64 && (side & (side - 1)) == 0 && tile_m > 0);
  Tile tile(side, tile_m, mix_bits(static_cast<std::uint32_t>(seed)));
  makers().at(kind)(tile);
  normalize(tile.values);
  return std::move(tile.values);
}

float smooth_noise(const Eigen::Vector3f& p_m, std::uint32_t seed) {
  const Eigen::Vector3f cell = p_m.array().floor();
  const Eigen::Vector3f t = p_m - cell;
  const Eigen::Vector3f s = t.array().square() * (3 - 2 * t.array());
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    std::uint32_t key = seed;
    float weight = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const int bit = corner >> axis & 1;
      key = hash_bits(key, static_cast<std::uint32_t>(static_cast<int>(cell[axis]) + bit));
      weight *= bit == 1 ? s[axis] : 1 - s[axis];
    }
    sum += weight * gaussian_of(key, 0);
  }
  return sum;
}

}  // namespace arpent::sim
