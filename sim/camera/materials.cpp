// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/materials.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <tuple>

#include "sim/world/pattern.h"

namespace arpent::sim {
namespace {

constexpr int kPatternSide = 1024;
constexpr int kMostTaps = 4;

/// To the nearest power of two, at most 2048, linear between pixels.
MipMap make_picture(const MeshPicture& picture) {
  const auto size = [](int n) { return static_cast<int>(std::min(2048U, std::bit_ceil(static_cast<unsigned>(n)))); };
  const int width = size(picture.width_px), height = size(picture.height_px);
  std::vector<float> values;
  for (int v = 0; v < height; ++v) {
    const float y = std::max(
        0.0F,
        (static_cast<float>(v) + 0.5F) * static_cast<float>(picture.height_px) / static_cast<float>(height) - 0.5F);
    const int v0 = std::min(static_cast<int>(y), picture.height_px - 1), v1 = std::min(v0 + 1, picture.height_px - 1);
    for (int u = 0; u < width; ++u) {
      const float x = std::max(
          0.0F,
          (static_cast<float>(u) + 0.5F) * static_cast<float>(picture.width_px) / static_cast<float>(width) - 0.5F);
      const int u0 = std::min(static_cast<int>(x), picture.width_px - 1), u1 = std::min(u0 + 1, picture.width_px - 1);
      const auto at = [&](int row, int column) {
        return static_cast<float>(
                   picture.values[static_cast<std::size_t>(row) * static_cast<std::size_t>(picture.width_px) +
                                  static_cast<std::size_t>(column)]) /
               255.0F;
      };
      const float a = x - static_cast<float>(u0), b = y - static_cast<float>(v0);
      values.push_back((1 - b) * ((1 - a) * at(v0, u0) + a * at(v0, u1)) + b * ((1 - a) * at(v1, u0) + a * at(v1, u1)));
    }
  }
  return {width, height, values};
}

float log2_of(float x) {
  return std::log2(std::max(1e-6F, x));
}

}  // namespace

Materials::Materials(const World& world, const SurfaceMesh& mesh) {
  std::map<std::tuple<std::string, int, double>, std::size_t> known;
  for (const TextureSpec& spec : world.textures) {
    const auto [entry, fresh] = known.emplace(std::tuple{spec.kind, spec.seed, spec.tile_m}, patterns_.size());
    if (fresh) {
      patterns_.emplace_back(kPatternSide, kPatternSide, make_pattern(spec.kind, spec.seed, spec.tile_m, kPatternSide));
    }
    Texture texture;
    texture.pattern = entry->second;
    texture.contrast = spec.kind == "plain" ? 0.0F : static_cast<float>(spec.contrast);
    texture.relative_contrast = texture.contrast / std::max(0.05F, static_cast<float>(spec.mean));
    texture.per_m = static_cast<float>(1 / spec.tile_m);
    textures_.push_back(texture);
  }
  for (const MeshPicture& picture : mesh.pictures) pictures_.push_back(make_picture(picture));
}

/// Adds the mean over the footprint: up to four samples along its major axis, each filtered to what is left.
void Materials::add_samples(const MipMap& map, const PlanarMap& to_uv, float scale, float texels_per_m,
                            const LanePoints& p, const PixelFootprint& footprint, Lanes& values) const {
  const float ratio = footprint.major_m / footprint.minor_m;
  const int taps = ratio < 1.5F ? 1 : ratio < 3 ? 2 : kMostTaps;
  const float step_m = footprint.major_m / static_cast<float>(taps);
  const float level = log2_of(std::sqrt(footprint.minor_m * std::max(footprint.minor_m, step_m)) * texels_per_m);
  Lanes u, v, sample;
  for (int tap = 0; tap < taps; ++tap) {
    const float along_m = (static_cast<float>(tap) + 0.5F - 0.5F * static_cast<float>(taps)) * step_m;
    const Eigen::Vector3f d = along_m * footprint.along;
    const float u0 = to_uv.a[0] * d.x() + to_uv.a[1] * d.y() + to_uv.a[2] * d.z() + to_uv.a[3];
    const float v0 = to_uv.b[0] * d.x() + to_uv.b[1] * d.y() + to_uv.b[2] * d.z() + to_uv.b[3];
    for (std::size_t i = 0; i < 8; ++i) {
      u[i] = scale * (to_uv.a[0] * p[0][i] + to_uv.a[1] * p[1][i] + to_uv.a[2] * p[2][i] + u0);
      v[i] = scale * (to_uv.b[0] * p[0][i] + to_uv.b[1] * p[1][i] + to_uv.b[2] * p[2][i] + v0);
    }
    map.sample(u, v, level, sample);
    for (std::size_t i = 0; i < 8; ++i) values[i] += sample[i] / static_cast<float>(taps);
  }
}

void Materials::reflectance(const Facet& facet, const LanePoints& p, const PixelFootprint& footprint,
                            Lanes& values) const {
  values.fill(0);
  if (facet.picture_index >= 0) {
    const MipMap& picture = pictures_[static_cast<std::size_t>(facet.picture_index)];
    const Eigen::Vector3f a(facet.picture.a[0], facet.picture.a[1], facet.picture.a[2]);
    const Eigen::Vector3f b(facet.picture.b[0], facet.picture.b[1], facet.picture.b[2]);
    const float texels = a.cross(b).norm() * static_cast<float>(picture.width()) * static_cast<float>(picture.height());
    add_samples(picture, facet.picture, 1, std::sqrt(texels), p, footprint, values);
  } else {
    values.fill(facet.reflectance);
  }
  if (facet.texture < 0 || facet.sharp) return;
  const Texture& texture = textures_[static_cast<std::size_t>(facet.texture)];
  if (texture.contrast <= 0) return;
  Lanes pattern{};
  add_samples(patterns_[texture.pattern], facet.pattern_m, texture.per_m,
              texture.per_m * static_cast<float>(kPatternSide), p, footprint, pattern);
  const bool on_picture = facet.picture_index >= 0;
  for (std::size_t i = 0; i < 8; ++i) {
    const float changed = on_picture ? values[i] * (1 + texture.relative_contrast * pattern[i])
                                     : values[i] + texture.contrast * pattern[i];
    values[i] = std::clamp(changed, 0.02F, 0.95F);
  }
}

}  // namespace arpent::sim
