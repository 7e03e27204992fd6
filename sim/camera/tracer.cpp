// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/tracer.h"

#include <embree3/rtcore.h>

#include <cstring>

#include "common/error.h"

namespace arpent::sim {
namespace {

constexpr float kNearestT = 1e-4F;

void* new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t stride, std::size_t count) {
  void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, stride, count);
  ARPENT_ASSERT(buffer != nullptr || count == 0);
  return buffer;
}

}  // namespace

struct Tracer::Scene {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<int> facets;  ///< of each triangle

  Scene() = default;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  ~Scene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
};

Tracer::Tracer(const SurfaceMesh& mesh, int first_facet) : scene_(std::make_unique<Scene>()) {
  scene_->device = rtcNewDevice("isa=avx2,threads=1");
  ARPENT_ASSERT(scene_->device != nullptr);
  scene_->scene = rtcNewScene(scene_->device);
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST);  // no ray slips through between two triangles
  RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertices =
      new_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices_m.size());
  std::memcpy(vertices, mesh.vertices_m.data(), 3 * sizeof(float) * mesh.vertices_m.size());
  void* indices =
      new_buffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size());
  std::memcpy(indices, mesh.triangles.data(), 3 * sizeof(std::uint32_t) * mesh.triangles.size());
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_->scene);
  scene_->facets.reserve(mesh.facet_of_triangle.size());
  for (const std::uint32_t facet : mesh.facet_of_triangle) {
    scene_->facets.push_back(first_facet + static_cast<int>(facet));
  }
}

Tracer::~Tracer() = default;
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;

void Tracer::intersect(RayPacket& packet, bool coherent) const {
  RTCRayHit8 query;
  alignas(32) int valid[kLanes];
  std::memcpy(query.ray.org_x, packet.origin.data(), sizeof packet.origin);
  std::memcpy(query.ray.dir_x, packet.direction.data(), sizeof packet.direction);
  std::memcpy(query.ray.tfar, packet.t.data(), sizeof packet.t);
  for (std::size_t i = 0; i < kLanes; ++i) {
    valid[i] = packet.t[i] >= 0 ? -1 : 0;
    query.ray.tnear[i] = kNearestT;
    query.ray.time[i] = 0;
    query.ray.mask[i] = 0xFFFFFFFFU;
    query.ray.id[i] = 0;
    query.ray.flags[i] = 0;
    query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcIntersect8(valid, scene_->scene, &context, &query);
  for (std::size_t i = 0; i < kLanes; ++i) {
    if (valid[i] == 0 || query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    packet.t[i] = query.ray.tfar[i];
    packet.facet[i] = scene_->facets[query.hit.primID[i]];
  }
}

void Tracer::find_occluded(RayPacket& packet) const {
  RTCRay8 query;
  alignas(32) int valid[kLanes];
  std::memcpy(query.org_x, packet.origin.data(), sizeof packet.origin);
  std::memcpy(query.dir_x, packet.direction.data(), sizeof packet.direction);
  std::memcpy(query.tfar, packet.t.data(), sizeof packet.t);
  for (std::size_t i = 0; i < kLanes; ++i) {
    valid[i] = packet.t[i] >= 0 ? -1 : 0;
    query.tnear[i] = kNearestT;
    query.time[i] = 0;
    query.mask[i] = 0xFFFFFFFFU;
    query.id[i] = 0;
    query.flags[i] = 0;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded8(valid, scene_->scene, &context, &query);
  // Embree marks a blocked ray with tfar = -infinity.
  for (std::size_t i = 0; i < kLanes; ++i) packet.facet[i] = valid[i] != 0 && query.tfar[i] < 0 ? 0 : -1;
}

}  // namespace arpent::sim
