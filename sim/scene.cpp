// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace arpent::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Hit {
  double distance = std::numeric_limits<double>::infinity();  ///< along the ray, whose direction has z_cam = 1
  Vector2d uv_m;                                              ///< on the surface
  Vector3d normal;
  const Surface* surface = nullptr;
};

/// A tile of 4 x 4 m of fractal noise with zero mean and unit deviation, and its halvings.
class Texture {
 public:
  static constexpr int kSide = 1024;
  static constexpr double kTexelsPerMetre = 256;

  Texture() {
    cv::Mat1f tile(kSide, kSide, 0.0F);
    cv::RNG rng(20);
    float amplitude = 1;
    for (int side = 8; side <= kSide; side *= 2, amplitude *= 0.86F) {
      cv::Mat1f noise(side, side);
      rng.fill(noise, cv::RNG::NORMAL, 0, amplitude);
      // Repeat the border so that the enlarged noise continues across the tile's edge.
      cv::Mat1f wide, large;
      cv::copyMakeBorder(noise, wide, 2, 2, 2, 2, cv::BORDER_WRAP);
      const int scale = kSide / side;
      cv::resize(wide, large, {}, scale, scale, scale == 1 ? cv::INTER_NEAREST : cv::INTER_CUBIC);
      tile += large(cv::Rect(2 * scale, 2 * scale, kSide, kSide));
    }
    cv::Scalar mean, deviation;
    cv::meanStdDev(tile, mean, deviation);
    levels_.push_back((tile - mean[0]) / deviation[0]);
    while (levels_.back().cols > 4) {
      cv::Mat1f half;
      cv::resize(levels_.back(), half, {}, 0.5, 0.5, cv::INTER_AREA);
      levels_.push_back(half);
    }
  }

  /// Value at uv [m], averaged over about `footprint_m`.
  [[nodiscard]] double at(const Vector2d& uv_m, double footprint_m) const {
    const double level = std::clamp(std::log2(std::max(1e-9, footprint_m * kTexelsPerMetre)), 0.0,
                                    static_cast<double>(levels_.size()) - 1.001);
    const auto lower = static_cast<std::size_t>(level);
    const double share = level - static_cast<double>(lower);
    return (1 - share) * bilinear(lower, uv_m) + share * bilinear(lower + 1, uv_m);
  }

 private:
  [[nodiscard]] double bilinear(std::size_t level, const Vector2d& uv_m) const {
    const cv::Mat1f& image = levels_[level];
    const int side = image.cols;
    const double scale = kTexelsPerMetre * side / kSide;
    const double u = uv_m.x() * scale - 0.5;
    const double v = uv_m.y() * scale - 0.5;
    const double fu = std::floor(u);
    const double fv = std::floor(v);
    const int mask = side - 1;
    const int u0 = static_cast<int>(fu) & mask, v0 = static_cast<int>(fv) & mask;
    const int u1 = (u0 + 1) & mask, v1 = (v0 + 1) & mask;
    const double a = u - fu;
    const double b = v - fv;
    return (1 - b) * ((1 - a) * image(v0, u0) + a * image(v0, u1)) + b * ((1 - a) * image(v1, u0) + a * image(v1, u1));
  }

  std::vector<cv::Mat1f> levels_;
};

void intersect(const Box& box, const Vector3d& origin, const Vector3d& ray, Hit& hit) {
  const double c = std::cos(box.yaw_rad), s = std::sin(box.yaw_rad);
  const auto turn = [&](const Vector3d& v) { return Vector3d(c * v.x() + s * v.y(), -s * v.x() + c * v.y(), v.z()); };
  const Vector3d o = turn(origin - box.centre_m);
  const Vector3d d = turn(ray);
  double enter = -std::numeric_limits<double>::infinity(), leave = -enter;
  int enter_axis = 0, leave_axis = 0;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(d[k]) < 1e-12) {
      if (std::abs(o[k]) > box.half_m[k]) return;
      continue;
    }
    double near = (-box.half_m[k] - o[k]) / d[k], far = (box.half_m[k] - o[k]) / d[k];
    if (near > far) std::swap(near, far);
    if (near > enter) {
      enter = near;
      enter_axis = k;
    }
    if (far < leave) {
      leave = far;
      leave_axis = k;
    }
  }
  if (enter > leave) return;
  const double t = box.inside_out ? leave : enter;
  const int axis = box.inside_out ? leave_axis : enter_axis;
  if (t <= 1e-6 || t >= hit.distance) return;
  if (box.open_top && axis == 2 && d.z() > 0) return;
  const Vector3d p = o + t * d;
  hit.distance = t;
  hit.uv_m = axis == 0 ? Vector2d(p.y(), p.z()) : axis == 1 ? Vector2d(p.x(), p.z()) : Vector2d(p.x(), p.y());
  hit.uv_m += Vector2d(box.surface.offset_m + 0.77 * axis, 1.31 * box.surface.offset_m + (p[axis] > 0 ? 0.5 : 0.0));
  Vector3d n = Vector3d::Zero();
  n[axis] = d[axis] > 0 ? -1 : 1;
  hit.normal = Vector3d(c * n.x() - s * n.y(), s * n.x() + c * n.y(), n.z());
  hit.surface = &box.surface;
}

void intersect(const Cylinder& cylinder, const Vector3d& origin, const Vector3d& ray, Hit& hit) {
  const Vector2d o = origin.head<2>() - cylinder.centre_m;
  const Vector2d d = ray.head<2>();
  const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - cylinder.radius_m * cylinder.radius_m;
  const double root2 = b * b - a * c;
  if (a < 1e-12 || root2 < 0) return;
  const double t = (-b - std::sqrt(root2)) / a;
  const double z = origin.z() + t * ray.z();
  if (t <= 1e-6 || t >= hit.distance || z < 0 || z > cylinder.height_m) return;
  const Vector2d n = (o + t * d) / cylinder.radius_m;
  hit.distance = t;
  hit.uv_m = Vector2d(std::atan2(n.y(), n.x()) * cylinder.radius_m + cylinder.surface.offset_m, z);
  hit.normal = Vector3d(n.x(), n.y(), 0);
  hit.surface = &cylinder.surface;
}

/// A number in [0, 1) for each pixel and seed, whatever the order in which pixels are drawn (splitmix64).
double uniform(std::uint64_t seed, std::uint64_t counter) {
  std::uint64_t x = seed * 0x9E3779B97F4A7C15ULL + counter * 0xD1342543DE82EF95ULL + 0x632BE59BD9B4E019ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1.0p-53;
}

double gaussian(std::uint64_t seed, std::uint64_t pixel) {
  const double u = 1.0 - uniform(seed, 2 * pixel);
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * uniform(seed, 2 * pixel + 1));
}

/// The light: from above, stronger near the middle of the hall, darker on surfaces turned away.
double light(const Vector3d& p, const Vector3d& normal) {
  static const Vector3d kLamp(4.0, 3.0, 4.5);
  const Vector3d to_lamp = kLamp - p;
  const double lambert = std::max(0.0, normal.dot(to_lamp.normalized()));
  return 0.55 + 0.75 * lambert / (1.0 + 0.02 * to_lamp.squaredNorm());
}

std::uint8_t to_level(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

void add_quad(TriangleMesh& mesh, const std::array<Vector3d, 4>& corners) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (const Vector3d& p : corners) mesh.vertices_m.push_back(p.cast<float>());
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

void add_box(TriangleMesh& mesh, const Box& box) {
  const Eigen::AngleAxisd yaw(box.yaw_rad, Vector3d::UnitZ());
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      if (box.open_top && axis == 2 && side == 1) continue;
      const Vector3d n = side * Vector3d::Unit(axis);
      const Vector3d a = Vector3d::Unit((axis + 1) % 3);
      const Vector3d b = n.cross(a);
      std::array<Vector3d, 4> corners;
      for (int i = 0; i < 4; ++i) {
        const double sa = i == 0 || i == 3 ? -1 : 1, sb = i < 2 ? -1 : 1;
        corners[static_cast<std::size_t>(i)] = box.centre_m + yaw * (n + sa * a + sb * b).cwiseProduct(box.half_m);
      }
      if (box.inside_out) std::reverse(corners.begin(), corners.end());
      add_quad(mesh, corners);
    }
  }
}

}  // namespace

Scene make_test_arena() {
  Scene scene;
  Box hall{{4, 3.5, 1}, {4, 3.5, 1}, 0, {115, 22, 0.3}, true, true};
  scene.boxes.push_back(hall);
  scene.boxes.push_back({{4.4, 3.5, 1}, {0.4, 0.4, 1}, 0, {140, 30, 1.9}, false, false});
  return scene;
}

Rendering render(const Scene& scene, const PinholeCamera& camera, const Pose& T_world_cam, const CameraNoise& noise,
                 std::uint64_t seed) {
  static const Texture texture;
  Rendering result{cv::Mat1b(camera.height_px, camera.width_px), cv::Mat1f(camera.height_px, camera.width_px, 0.0F)};
  const Vector3d origin = T_world_cam.translation();
  const double corner2 = 0.25 * (camera.width_px * camera.width_px + camera.height_px * camera.height_px);
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      const Vector3d ray = T_world_cam.linear() * camera.unproject(u, v, 1.0);
      Hit hit;
      for (const Box& box : scene.boxes) intersect(box, origin, ray, hit);
      for (const Cylinder& cylinder : scene.cylinders) intersect(cylinder, origin, ray, hit);
      double level = 4;  // the dark void above
      if (hit.surface != nullptr) {
        const double cosine = std::max(0.05, std::abs(hit.normal.dot(ray)) / ray.norm());
        // Between the footprint along and across the slant: blur neither too much nor too little.
        const double footprint_m = hit.distance / camera.fx_px / std::sqrt(cosine);
        level = (hit.surface->mean + hit.surface->contrast * texture.at(hit.uv_m, footprint_m)) *
                light(origin + hit.distance * ray, hit.normal);
        result.depth_m(v, u) = static_cast<float>(hit.distance);
      }
      const double du = u - camera.cx_px, dv = v - camera.cy_px;
      level *= 1.0 - noise.vignetting * (du * du + dv * dv) / corner2;
      const auto pixel =
          static_cast<std::uint64_t>(v) * static_cast<std::uint64_t>(camera.width_px) + static_cast<std::uint64_t>(u);
      const double sigma = std::sqrt(noise.read_levels * noise.read_levels +
                                     noise.shot_levels * noise.shot_levels * std::max(0.0, level));
      result.image(v, u) = to_level(level + (sigma > 0 ? sigma * gaussian(seed, pixel) : 0.0));
    }
  }
  return result;
}

TriangleMesh to_mesh(const Scene& scene) {
  TriangleMesh mesh;
  for (const Box& box : scene.boxes) add_box(mesh, box);
  constexpr int kSides = 64;
  for (const Cylinder& cylinder : scene.cylinders) {
    for (int i = 0; i < kSides; ++i) {
      const auto rim = [&](int k, double z) {
        const double angle = 2 * std::numbers::pi * k / kSides;
        return Vector3d(cylinder.centre_m.x() + cylinder.radius_m * std::cos(angle),
                        cylinder.centre_m.y() + cylinder.radius_m * std::sin(angle), z);
      };
      add_quad(mesh, {rim(i, 0), rim(i + 1, 0), rim(i + 1, cylinder.height_m), rim(i, cylinder.height_m)});
    }
  }
  return mesh;
}

}  // namespace arpent::sim
