// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/light_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/world/noise.h"

namespace arpent::sim {
namespace {

using Eigen::Vector3f;

constexpr int kGatherRays = 32;
constexpr int kLampSamples = 16;
constexpr float kAllBounces = 1.6F;     ///< of light, over the first: 1 / (1 - mean reflectance)
constexpr float kOffsetM = 0.01F;       ///< of ray origins above their surface
constexpr float kAmbientReachM = 1.5F;  ///< surfaces nearer than this shut ambient light out
constexpr float kFarthestM = 40;        ///< from where light is thrown back
constexpr double kFinestSpacingM = 0.2;
constexpr double kMostNodes = 40000;
constexpr float kAroundM = 3;  ///< facets farther from the region than this get a light of their corners only

float area_of(const Facet& facet) {
  return facet.u_m.cross(facet.v_m).norm() * (facet.triangle ? 0.5F : 1.0F);
}

bool near_region(const Facet& facet, const Region& region) {
  const Vector3f corners[] = {facet.origin_m, facet.origin_m + facet.u_m, facet.origin_m + facet.v_m,
                              facet.origin_m + facet.u_m + facet.v_m};
  Vector3f least = corners[0], most = corners[0];
  for (const Vector3f& corner : corners) {
    least = least.cwiseMin(corner);
    most = most.cwiseMax(corner);
  }
  return (most.array() > region.min_m.cast<float>().array() - kAroundM).all() &&
         (least.array() < region.max_m.cast<float>().array() + kAroundM).all();
}

/// i-th of `n` points spread evenly over the unit square (Hammersley).
Eigen::Vector2f spread(int i, int n) {
  auto bits = static_cast<std::uint32_t>(i);
  std::uint32_t reversed = 0;
  for (int k = 0; k < 32; ++k, bits >>= 1) reversed = reversed << 1 | (bits & 1);
  return {(static_cast<float>(i) + 0.5F) / static_cast<float>(n), static_cast<float>(reversed >> 8) * 0x1.0p-24F};
}

/// Directions around +z, more of them near it as the cosine demands.
std::array<Vector3f, kGatherRays> cosine_directions() {
  std::array<Vector3f, kGatherRays> all;
  for (int i = 0; i < kGatherRays; ++i) {
    const Eigen::Vector2f s = spread(i, kGatherRays);
    const float r = std::sqrt(s.x()), angle = 2 * std::numbers::pi_v<float> * s.y();
    all[static_cast<std::size_t>(i)] = Vector3f(r * std::cos(angle), r * std::sin(angle), std::sqrt(1 - s.x()));
  }
  return all;
}

void set_ray(RayPacket& packet, std::size_t lane, const Vector3f& origin, const Vector3f& direction, float t) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    packet.origin[axis][lane] = origin[static_cast<int>(axis)];
    packet.direction[axis][lane] = direction[static_cast<int>(axis)];
  }
  packet.t[lane] = t;
  packet.facet[lane] = -1;
}

struct LampRay {
  Vector3f to_lamp;
  float light;
};

/// Unshadowed light of one lamp at p, as rays towards points of the lamp.
void add_lamp_rays(const Lamp& lamp, const Vector3f& p, const Vector3f& n, int samples, std::vector<LampRay>& rays) {
  const bool point_like = lamp.size_m.isZero() || samples == 1;
  const int count = point_like ? 1 : samples;
  for (int i = 0; i < count; ++i) {
    Vector3f at = lamp.position_m.cast<float>();
    if (!point_like) {
      const Eigen::Vector2f s = spread(i, count);
      const float third = (static_cast<float>((i * 5) % count) + 0.5F) / static_cast<float>(count);
      at += Vector3f(s.x() - 0.5F, s.y() - 0.5F, third - 0.5F).cwiseProduct(lamp.size_m.cast<float>());
    }
    const Vector3f to_lamp = at - p;
    const float r2 = to_lamp.squaredNorm();
    const Vector3f l = to_lamp / std::sqrt(std::max(1e-6F, r2));
    float light =
        static_cast<float>(lamp.intensity) * std::max(0.0F, n.dot(l)) / (r2 + 0.05F) / static_cast<float>(count);
    if (!lamp.direction.isZero()) {
      const float cosine = std::max(0.0F, -l.dot(lamp.direction.cast<float>().normalized()));
      light *= std::pow(cosine, static_cast<float>(lamp.focus));
    }
    if (light > 1e-5F) rays.push_back({to_lamp, light});
  }
}

}  // namespace

float LightMap::at(std::size_t facet, const Eigen::Vector2f& patch) const {
  const Grid& g = grids_[facet];
  const float x = std::clamp(patch.x(), 0.0F, 1.0F) * static_cast<float>(g.nu - 1);
  const float y = std::clamp(patch.y(), 0.0F, 1.0F) * static_cast<float>(g.nv - 1);
  const int i = std::min(static_cast<int>(x), g.nu - 2), j = std::min(static_cast<int>(y), g.nv - 2);
  const float a = x - static_cast<float>(i), b = y - static_cast<float>(j);
  const float* v = values_.data() + g.offset + j * g.nu + i;
  const float low = v[0] + a * (v[1] - v[0]), high = v[g.nu] + a * (v[g.nu + 1] - v[g.nu]);
  return low + b * (high - low);
}

float LightBaker::direct(const Vector3f& p, const Vector3f& n, int samples) const {
  std::vector<LampRay> rays;
  for (const Lamp& lamp : world_.lighting.lamps) add_lamp_rays(lamp, p, n, samples, rays);
  float sum = 0;
  for (std::size_t first = 0; first < rays.size(); first += kLanes) {
    RayPacket packet;
    for (std::size_t k = 0; k < kLanes; ++k) {
      const bool used = first + k < rays.size();
      set_ray(packet, k, p, used ? rays[first + k].to_lamp : n, used ? 0.98F : -1.0F);
    }
    tracer_.find_occluded(packet);
    for (std::size_t k = 0; k < kLanes && first + k < rays.size(); ++k) {
      if (packet.facet[k] < 0) sum += rays[first + k].light;
    }
  }
  return sum;
}

float LightBaker::gather(const Vector3f& p, const Vector3f& n, const LightMap& light) const {
  static const auto directions = cosine_directions();
  const Vector3f x = (std::abs(n.z()) < 0.9F ? Vector3f::UnitZ() : Vector3f::UnitX()).cross(n).normalized();
  const Vector3f y = n.cross(x);
  float thrown_back = 0, open = 0;
  for (int first = 0; first < kGatherRays; first += kLanes) {
    RayPacket packet;
    for (std::size_t k = 0; k < kLanes; ++k) {
      const Vector3f& d = directions[static_cast<std::size_t>(first) + k];
      set_ray(packet, k, p, d.x() * x + d.y() * y + d.z() * n, kFarthestM);
    }
    tracer_.intersect_scattered(packet);
    for (std::size_t k = 0; k < kLanes; ++k) {
      const int facet = packet.facet[k];
      open += facet < 0 ? 1.0F : std::min(1.0F, packet.t[k] / kAmbientReachM);
      if (facet < 0) continue;
      Vector3f hit;
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        hit[axis] = packet.origin[a][k] + packet.t[k] * packet.direction[a][k];
      }
      const auto index = static_cast<std::size_t>(facet);
      const Facet& seen = mesh_.facets[index];
      const float reflectance = seen.picture_index >= 0 ? 0.4F : seen.reflectance;
      thrown_back += reflectance * light.at(index, seen.patch.at(hit));
    }
  }
  return (kAllBounces * thrown_back + open * static_cast<float>(world_.lighting.ambient)) / kGatherRays;
}

LightMap LightBaker::make_grids() const {
  double area = 0;
  for (const Facet& facet : mesh_.facets) {
    if (near_region(facet, world_.region)) area += static_cast<double>(area_of(facet));
  }
  const double spacing_m = std::max(kFinestSpacingM, std::sqrt(area / kMostNodes));
  LightMap light;
  int offset = 0;
  for (const Facet& facet : mesh_.facets) {
    const auto nodes = [&](const Vector3f& edge) {
      return std::clamp(1 + static_cast<int>(std::ceil(static_cast<double>(edge.norm()) / spacing_m)), 2, 400);
    };
    const bool fine = near_region(facet, world_.region);
    const LightMap::Grid grid{offset, fine ? nodes(facet.u_m) : 2, fine ? nodes(facet.v_m) : 2};
    light.grids_.push_back(grid);
    offset += grid.nu * grid.nv;
  }
  light.values_.assign(static_cast<std::size_t>(offset), 0.0F);
  return light;
}

template <class Function>
void LightBaker::for_each_node(LightMap& light, Function function) const {
  for (std::size_t f = 0; f < mesh_.facets.size(); ++f) {
    const Facet& facet = mesh_.facets[f];
    const LightMap::Grid& grid = light.grids_[f];
    for (int j = 0; j < grid.nv; ++j) {
      for (int i = 0; i < grid.nu; ++i) {
        // Not on the border itself: there the neighbouring wall begins.
        float a = std::clamp(static_cast<float>(i) / static_cast<float>(grid.nu - 1), 0.01F, 0.99F);
        float b = std::clamp(static_cast<float>(j) / static_cast<float>(grid.nv - 1), 0.01F, 0.99F);
        if (facet.triangle && a + b > 0.98F) {
          const float shrink = 0.98F / (a + b);
          a *= shrink;
          b *= shrink;
        }
        const Vector3f p = facet.origin_m + a * facet.u_m + b * facet.v_m + kOffsetM * facet.normal;
        function(facet, p, light.values_[static_cast<std::size_t>(grid.offset + j * grid.nu + i)]);
      }
    }
  }
}

LightMap LightBaker::bake() {
  LightMap lamps = make_grids();
  for_each_node(lamps, [&](const Facet& facet, const Vector3f& p, float& value) {
    value = direct(p, facet.normal, kLampSamples);
  });
  LightMap total = lamps;
  for_each_node(total,
                [&](const Facet& facet, const Vector3f& p, float& value) { value += gather(p, facet.normal, lamps); });
  const double light = mean_over_region(total);
  scale_ = light > 0 ? static_cast<float>(world_.lighting.mean / light) : 1.0F;
  mean_indirect_ = static_cast<float>(light - mean_over_region(lamps));
  for_each_node(total, [&](const Facet& facet, const Vector3f& p, float& value) {
    if (facet.texture < 0) {
      value *= scale_;
      return;
    }
    const auto stains = static_cast<float>(world_.textures[static_cast<std::size_t>(facet.texture)].stains);
    const auto seed = static_cast<std::uint32_t>(facet.surface);
    const float change = 1.8F * smooth_noise(0.8F * p, seed) + smooth_noise(2.1F * p, seed + 99);
    value *= scale_ * std::max(0.2F, 1 + stains * change);
  });
  return total;
}

double LightBaker::mean_over_region(const LightMap& light) const {
  double sum = 0, area = 0;
  for (std::size_t f = 0; f < mesh_.facets.size(); ++f) {
    const Facet& facet = mesh_.facets[f];
    const Vector3f middle = facet.origin_m + (facet.triangle ? 0.33F : 0.5F) * (facet.u_m + facet.v_m);
    if (!world_.region.contains((middle + kOffsetM * facet.normal).cast<double>())) continue;
    const LightMap::Grid& g = light.grids_[f];
    double values = 0;
    for (int k = 0; k < g.nu * g.nv; ++k)
      values += static_cast<double>(light.values_[static_cast<std::size_t>(g.offset + k)]);
    sum += static_cast<double>(area_of(facet)) * values / (g.nu * g.nv);
    area += static_cast<double>(area_of(facet));
  }
  return area > 0 ? sum / area : 0;
}

LightMap LightBaker::bake_body(const SurfaceMesh& body) const {
  LightMap light;
  for (const Facet& facet : body.facets) {
    light.grids_.push_back({static_cast<int>(light.values_.size()), 2, 2});
    const Vector3f p = facet.origin_m + 0.5F * (facet.u_m + facet.v_m) + kOffsetM * facet.normal;
    const float value = scale_ * (direct(p, facet.normal, 1) + mean_indirect_);
    light.values_.insert(light.values_.end(), 4, value);
  }
  return light;
}

}  // namespace arpent::sim
