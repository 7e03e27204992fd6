// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/camera/body.h"
#include "sim/camera/light_map.h"
#include "sim/camera/materials.h"
#include "sim/camera/tracer.h"

namespace arpent::sim {
namespace {

using Eigen::Vector3f;

constexpr float kFar = 1e6F;
constexpr int kNothing = -1;

/// Where eight rays leave a pixel when surfaces meet in it: each row and column of an 8 x 8 grid once.
constexpr std::array<std::array<float, 2>, kLanes> kSubpixels{{{-0.4375F, -0.0625F},
                                                               {-0.3125F, 0.3125F},
                                                               {-0.1875F, -0.3125F},
                                                               {-0.0625F, 0.1875F},
                                                               {0.0625F, -0.4375F},
                                                               {0.1875F, 0.0625F},
                                                               {0.3125F, 0.4375F},
                                                               {0.4375F, -0.1875F}}};
/// What one of them sees is smaller than the pixel by the root of their number.
constexpr float kSubpixelSize = 0.354F;

/// A mesh with its light.
struct Part {
  const SurfaceMesh* mesh;
  const LightMap* light;
};

/// One picture in the making.
struct View {
  const Tracer* world_tracer = nullptr;
  const Tracer* body_tracer = nullptr;
  std::array<Part, 2> parts{};  ///< the world, the bodies
  const Materials* materials = nullptr;
  float sky = 0;
  Eigen::Matrix3f R_world_cam;
  Vector3f origin_m;
  float pixel_rad = 0;  ///< width of a pixel at depth 1

  [[nodiscard]] const Part& part_of(int& facet) const {
    const int in_world = static_cast<int>(parts[0].mesh->facets.size());
    if (facet < in_world) return parts[0];
    facet -= in_world;
    return parts[1];
  }
};

/// What tracing needs; without the looks of things.
View view_from(const Pose& T_world_cam, const Tracer& world, const Tracer* bodies) {
  View view;
  view.world_tracer = &world;
  view.body_tracer = bodies;
  view.R_world_cam = T_world_cam.linear().cast<float>();
  view.origin_m = T_world_cam.translation().cast<float>();
  return view;
}

/// Rays through (x, y, 1) in camera axes; t becomes depth.
RayPacket make_packet(const View& view, const Lanes& x, const Lanes& y) {
  RayPacket packet;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<int>(axis);
    packet.origin[axis].fill(view.origin_m[row]);
    const float rx = view.R_world_cam(row, 0), ry = view.R_world_cam(row, 1), rz = view.R_world_cam(row, 2);
    for (std::size_t i = 0; i < kLanes; ++i) packet.direction[axis][i] = rx * x[i] + ry * y[i] + rz;
  }
  packet.t.fill(kFar);
  packet.facet.fill(kNothing);
  return packet;
}

void trace(const View& view, RayPacket& packet) {
  view.world_tracer->intersect(packet);
  if (view.body_tracer != nullptr) view.body_tracer->intersect(packet);
}

/// Light at eight points of a facet (LightMap::at for lanes).
void light_at(const Part& part, std::size_t index, const LanePoints& p, Lanes& light) {
  const Facet& facet = part.mesh->facets[index];
  const LightMap::Grid& grid = part.light->grid(index);
  const auto most_u = static_cast<float>(grid.nu - 1), most_v = static_cast<float>(grid.nv - 1);
  const float* values = part.light->values() + grid.offset;
  std::array<int, kLanes> at;
  Lanes a, b;
  const auto& mu = facet.patch.a;
  const auto& mv = facet.patch.b;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float x = std::clamp(mu[0] * p[0][i] + mu[1] * p[1][i] + mu[2] * p[2][i] + mu[3], 0.0F, 1.0F) * most_u;
    const float y = std::clamp(mv[0] * p[0][i] + mv[1] * p[1][i] + mv[2] * p[2][i] + mv[3], 0.0F, 1.0F) * most_v;
    const float fx = std::min(std::floor(x), most_u - 1), fy = std::min(std::floor(y), most_v - 1);
    a[i] = x - fx;
    b[i] = y - fy;
    at[i] = static_cast<int>(fy) * grid.nu + static_cast<int>(fx);
  }
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float* v = values + at[i];
    const float low = v[0] + a[i] * (v[1] - v[0]);
    const float high = v[grid.nu] + a[i] * (v[grid.nu + 1] - v[grid.nu]);
    light[i] = low + b[i] * (high - low);
  }
}

/// The pixel's footprint on a facet, from one of the packet's rays.
PixelFootprint footprint_of(const View& view, const RayPacket& packet, std::size_t lane, const Vector3f& normal,
                            float size) {
  const Vector3f d(packet.direction[0][lane], packet.direction[1][lane], packet.direction[2][lane]);
  const float along_normal = d.dot(normal);
  const float slant = d.norm() / std::max(1e-3F, std::abs(along_normal));
  PixelFootprint footprint;
  footprint.minor_m = size * packet.t[lane] * view.pixel_rad;
  footprint.major_m = footprint.minor_m * slant;
  footprint.along = (d - along_normal * normal).normalized();
  return footprint;
}

/// Radiance that comes along each ray. Neighbouring rays mostly hit the same facet: each facet is done once.
void shade(const View& view, const RayPacket& packet, float size, Lanes& radiance) {
  radiance.fill(view.sky);
  LanePoints p;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      p[axis][i] = packet.origin[axis][i] + packet.t[i] * packet.direction[axis][i];
    }
  }
  // Lanes that hit nothing have no point; any number will do.
  for (std::size_t i = 0; i < kLanes; ++i) {
    if (packet.facet[i] == kNothing) p[0][i] = p[1][i] = p[2][i] = 0;
  }
  std::array<bool, kLanes> done{};
  for (std::size_t first = 0; first < kLanes; ++first) {
    const int hit = packet.facet[first];
    if (hit == kNothing || done[first]) continue;
    int index = hit;
    const Part& part = view.part_of(index);
    const Facet& facet = part.mesh->facets[static_cast<std::size_t>(index)];
    Lanes reflectance, light;
    view.materials->reflectance(facet, p, footprint_of(view, packet, first, facet.normal, size), reflectance);
    light_at(part, static_cast<std::size_t>(index), p, light);
    for (std::size_t i = 0; i < kLanes; ++i) {
      if (packet.facet[i] != hit) continue;
      radiance[i] = reflectance[i] * light[i] + facet.glow;
      done[i] = true;
    }
  }
}

/// Pictures of radiance and depth, and what each pixel shows: twice the group, odd if it must not be blurred.
struct Buffers {
  cv::Mat1f radiance;
  cv::Mat1f depth_m;
  cv::Mat1i group;

  explicit Buffers(const cv::Size& size) : radiance(size), depth_m(size), group(size) {}
};

int group_of(const View& view, int facet) {
  if (facet == kNothing) return kNothing * 2;
  int index = facet;
  const Part& part = view.part_of(index);
  const Facet& hit = part.mesh->facets[static_cast<std::size_t>(index)];
  const int bodies_after = part.mesh == view.parts[0].mesh ? 0 : view.parts[0].mesh->groups;
  return 2 * (bodies_after + hit.group) + (hit.sharp ? 1 : 0);
}

using Pixels = std::array<int, kLanes>;

/// Calls with the columns, the rows and what their centres hit, for blocks of 4 x 2 pixels. Lanes beyond the border
/// repeat the last pixel.
template <class Take>
void for_each_packet(const View& view, const CameraModel& camera, Take take) {
  const int width = camera.width_px(), height = camera.height_px();
  Lanes x, y;
  for (int v0 = 0; v0 < height; v0 += 2) {
    for (int u0 = 0; u0 < width; u0 += 4) {
      Pixels us, vs;
      for (std::size_t i = 0; i < kLanes; ++i) {
        us[i] = std::min(u0 + static_cast<int>(i % 4), width - 1);
        vs[i] = std::min(v0 + static_cast<int>(i / 4), height - 1);
        const std::size_t pixel =
            static_cast<std::size_t>(vs[i]) * static_cast<std::size_t>(width) + static_cast<std::size_t>(us[i]);
        x[i] = camera.ray_x()[pixel];
        y[i] = camera.ray_y()[pixel];
      }
      RayPacket packet = make_packet(view, x, y);
      trace(view, packet);
      take(us, vs, packet);
    }
  }
}

void take_depth(const Pixels& us, const Pixels& vs, const RayPacket& packet, cv::Mat1f& depth_m) {
  for (std::size_t i = 0; i < kLanes; ++i) {
    depth_m(vs[i], us[i]) = packet.facet[i] == kNothing ? 0.0F : packet.t[i];
  }
}

void trace_centres(const View& view, const CameraModel& camera, Buffers& buffers) {
  for_each_packet(view, camera, [&](const Pixels& us, const Pixels& vs, const RayPacket& packet) {
    Lanes radiance;
    shade(view, packet, 1, radiance);
    take_depth(us, vs, packet, buffers.depth_m);
    for (std::size_t i = 0; i < kLanes; ++i) {
      buffers.radiance(vs[i], us[i]) = radiance[i];
      buffers.group(vs[i], us[i]) = i > 0 && packet.facet[i] == packet.facet[i - 1]
                                        ? buffers.group(vs[i - 1], us[i - 1])
                                        : group_of(view, packet.facet[i]);
    }
  });
}

/// Eight rays within the pixel instead of one.
void refine_pixel(const View& view, const CameraModel& camera, int u, int v, Buffers& buffers) {
  const int width = camera.width_px(), height = camera.height_px();
  const auto at = [&](int column, int row) {
    const auto i = static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
    return Eigen::Vector2f(camera.ray_x()[i], camera.ray_y()[i]);
  };
  const Eigen::Vector2f centre = at(u, v);
  const Eigen::Vector2f du = u + 1 < width ? at(u + 1, v) - centre : centre - at(u - 1, v);
  const Eigen::Vector2f dv = v + 1 < height ? at(u, v + 1) - centre : centre - at(u, v - 1);
  Lanes x, y, radiance;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Eigen::Vector2f p = centre + kSubpixels[i][0] * du + kSubpixels[i][1] * dv;
    x[i] = p.x();
    y[i] = p.y();
  }
  RayPacket packet = make_packet(view, x, y);
  trace(view, packet);
  shade(view, packet, kSubpixelSize, radiance);
  float sum = 0;
  // What is brighter than the sensor can tell must not outshine the rest of its pixel.
  for (const float value : radiance) sum += value;
  buffers.radiance(v, u) = sum / kLanes;
}

void refine_edges(const View& view, const CameraModel& camera, Buffers& buffers) {
  const int width = camera.width_px(), height = camera.height_px();
  for (int v = 0; v < height; ++v) {
    const int* row = buffers.group.ptr<int>(v);
    const int* above = buffers.group.ptr<int>(std::max(0, v - 1));
    const int* below = buffers.group.ptr<int>(std::min(height - 1, v + 1));
    for (int u = 0; u < width; ++u) {
      const int group = row[u];
      const bool edge = (group & 1) != 0 || group != above[u] || group != below[u] ||
                        group != row[std::max(0, u - 1)] || group != row[std::min(width - 1, u + 1)];
      if (edge) refine_pixel(view, camera, u, v, buffers);
    }
  }
}

}  // namespace

struct Renderer::Scene {
  World world;
  SurfaceMesh mesh;
  Tracer tracer;
  Materials materials;
  LightBaker baker;
  LightMap light;

  explicit Scene(const World& w)
      : world(w),
        mesh(make_surface_mesh(world)),
        tracer(mesh),
        materials(world, mesh),
        baker(world, mesh, tracer),
        light(baker.bake()) {}
};

Renderer::Renderer(const World& world) : scene_(std::make_unique<const Scene>(world)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

namespace {

SurfaceMesh mesh_of(std::span<const Body> bodies) {
  SurfaceMesh mesh;
  for (const Body& body : bodies) add_robot(mesh, body.T_world_body);
  return mesh;
}

/// None for no bodies. Their facets are numbered after those of the world.
std::unique_ptr<const Tracer> trace_bodies(const SurfaceMesh& bodies, const SurfaceMesh& world) {
  if (bodies.facets.empty()) return nullptr;
  return std::make_unique<const Tracer>(bodies, static_cast<int>(world.facets.size()));
}

}  // namespace

CameraImage Renderer::render(const CameraModel& camera, const Pose& T_world_cam, const CameraShot& shot,
                             std::span<const Body> bodies) const {
  const SurfaceMesh body_mesh = mesh_of(bodies);
  const LightMap body_light = scene_->baker.bake_body(body_mesh);
  const std::unique_ptr<const Tracer> body_tracer = trace_bodies(body_mesh, scene_->mesh);
  View view = view_from(T_world_cam, scene_->tracer, body_tracer.get());
  view.parts = {Part{&scene_->mesh, &scene_->light}, Part{&body_mesh, &body_light}};
  view.materials = &scene_->materials;
  view.sky = static_cast<float>(scene_->world.lighting.sky);
  view.pixel_rad = static_cast<float>(1 / camera.camera().pinhole.fx_px);
  Buffers buffers(cv::Size(camera.width_px(), camera.height_px()));
  trace_centres(view, camera, buffers);
  refine_edges(view, camera, buffers);
  return {camera.expose(buffers.radiance, buffers.depth_m, shot), buffers.depth_m};
}

cv::Mat1f Renderer::depth_m(const CameraModel& camera, const Pose& T_world_cam, std::span<const Body> bodies) const {
  const std::unique_ptr<const Tracer> body_tracer = trace_bodies(mesh_of(bodies), scene_->mesh);
  const View view = view_from(T_world_cam, scene_->tracer, body_tracer.get());
  cv::Mat1f depth_m(camera.height_px(), camera.width_px());
  for_each_packet(view, camera, [&](const Pixels& us, const Pixels& vs, const RayPacket& packet) {
    take_depth(us, vs, packet, depth_m);
  });
  return depth_m;
}

std::optional<double> Renderer::irradiance(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction) const {
  RayPacket packet;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    packet.origin[axis].fill(static_cast<float>(from_m[static_cast<int>(axis)]));
    packet.direction[axis].fill(static_cast<float>(direction[static_cast<int>(axis)]));
  }
  packet.t.fill(-1);
  packet.t[0] = kFar;
  packet.facet.fill(kNothing);
  scene_->tracer.intersect(packet);
  if (packet.facet[0] == kNothing) return std::nullopt;
  const Vector3f p = (from_m + static_cast<double>(packet.t[0]) * direction).cast<float>();
  const auto facet = static_cast<std::size_t>(packet.facet[0]);
  return static_cast<double>(scene_->light.at(facet, scene_->mesh.facets[facet].patch.at(p)));
}

}  // namespace arpent::sim
