// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `tsdf`: the map on the workload of workload.h at voxels of 0.1, 0.2 and 0.05 m: time of one integration and of
// meshing one more frame, coverage and accuracy of the mesh, ghost sheets, false incomplete surface, size on disk.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>
#include <unordered_map>

#include "bench/harness.h"
#include "bench/mapping/tsdf/workload.h"
#include "mapping/surface/mesh_extraction.h"
#include "mapping/tsdf/map_file.h"
#include "mapping/tsdf/query.h"
#include "mapping/tsdf/storage.h"
#include "mapping/tsdf/tsdf_map.h"
#include "tools/evaluation/mesh.h"
#include "tools/evaluation/surface_index.h"

namespace arpent {
namespace {

using mapping::TsdfMap;

constexpr int kMeshSamples = 300000;
constexpr double kTruthSpacingM = 0.03;
/// Frames between two timings of the reference.
constexpr int kReferenceEvery = 15;
/// Of the last frames, how long meshing takes after each.
constexpr int kMeshedFrames = 21;

/// Triangles by the cells of a grid that their neighbourhood touches.
class NearbyTriangles {
 public:
  NearbyTriangles(const TriangleMesh& mesh, double radius_m) : mesh_(mesh), radius_m_(radius_m) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      Eigen::AlignedBox3d box;
      for (const std::uint32_t v : mesh.triangles[t]) box.extend(mesh.vertices_m[v].cast<double>());
      const Eigen::Vector3i least = cell(box.min().array() - radius_m), most = cell(box.max().array() + radius_m);
      for (int z = least.z(); z <= most.z(); ++z) {
        for (int y = least.y(); y <= most.y(); ++y) {
          for (int x = least.x(); x <= most.x(); ++x) cells_[{x, y, z}].push_back(t);
        }
      }
    }
  }

  [[nodiscard]] bool any_within(const Eigen::Vector3d& p) const {
    const auto found = cells_.find(cell(p));
    return found != cells_.end() && std::any_of(found->second.begin(), found->second.end(), [&](std::uint32_t t) {
             const auto corner = [&](std::size_t i) -> Eigen::Vector3d {
               return mesh_.vertices_m[mesh_.triangles[t][i]].cast<double>();
             };
             return evaluation::point_triangle_distance(p, corner(0), corner(1), corner(2)) <= radius_m_;
           });
  }

 private:
  [[nodiscard]] Eigen::Vector3i cell(const Eigen::Vector3d& p) const {
    return (p / (2 * radius_m_)).array().floor().cast<int>();
  }

  const TriangleMesh& mesh_;
  double radius_m_;
  std::unordered_map<Eigen::Vector3i, std::vector<std::uint32_t>, mapping::BlockHash> cells_;
};

/// Voxels beside the surface (|distance| < voxel) that border on both free and never seen space: in a room that was
/// seen all around, these are what would send an explorer on a useless trip.
int count_false_ise(const TsdfMap& map) {
  constexpr std::array<std::array<int, 3>, 6> kNeighbours = {
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  int count = 0;
  for (const auto& block : map.storage().blocks) {
    for (int i = 0; i < mapping::kBlockVoxels; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (!(block->weight[at] > 0) || std::abs(block->distance_m[at]) >= map.params().voxel_m) continue;
      const mapping::VoxelIndex index =
          block->index * mapping::kBlockSide + Eigen::Vector3i(i & 7, (i >> 3) & 7, i >> 6);
      bool unknown = false;
      bool free = false;
      for (const auto& n : kNeighbours) {
        const auto voxel = map.voxel(index + Eigen::Vector3i(n[0], n[1], n[2]));
        unknown = unknown || !voxel;
        free = free || (voxel && voxel->distance_m > 0);
      }
      count += unknown && free ? 1 : 0;
    }
  }
  return count;
}

struct Truth {
  bench::Room room;
  std::vector<Eigen::Vector3d> observed_map_m;
  double observed_m2 = 0;
};

Truth make_truth() {
  Truth truth;
  for (const auto& p : bench::keep_observed(truth.room, truth.room.sample_surface(kTruthSpacingM))) {
    truth.observed_map_m.push_back(truth.room.T_map_scene() * p);
  }
  truth.observed_m2 = static_cast<double>(truth.observed_map_m.size()) * kTruthSpacingM * kTruthSpacingM;
  return truth;
}

void measure_mesh(bench::Report& report, const std::string& suffix, const Truth& truth, const TriangleMesh& mesh,
                  double voxel_m) {
  const bool judged = voxel_m == 0.1;
  const double e_max = voxel_m * std::sqrt(3.0) / 2;
  const NearbyTriangles nearby(mesh, e_max);
  const auto covered = std::count_if(truth.observed_map_m.begin(), truth.observed_map_m.end(),
                                     [&](const Eigen::Vector3d& p) { return nearby.any_within(p); });
  report.add("tsdf.coverage" + suffix,
             100.0 * static_cast<double>(covered) / static_cast<double>(truth.observed_map_m.size()), "%",
             judged ? "bar >= 98.5" : "");
  double squares = 0, trimmed = 0, ghosts = 0;
  const auto samples = evaluation::sample_surface(mesh, 1e9, kMeshSamples, 1);
  const Pose T_scene_map = truth.room.T_map_scene().inverse();
  for (const Eigen::Vector3d& p : samples.points_m) {
    const double d = truth.room.distance(T_scene_map * p);
    squares += d * d;
    if (d > e_max) {
      ++ghosts;
    } else {
      trimmed += d * d;
    }
  }
  const auto count = static_cast<double>(samples.points_m.size());
  report.add("tsdf.rmse_trim_cm" + suffix, 100 * std::sqrt(trimmed / (count - ghosts)), "cm",
             judged ? "bar <= 0.65" : "");
  report.add("tsdf.ghost_percent" + suffix, 100 * ghosts / count, "%", judged ? "bar <= 0.3" : "");
  report.add("tsdf.rmse_cm" + suffix, 100 * std::sqrt(squares / count), "cm");
}

double bytes_on_disk(const TsdfMap& map) {
  const auto path = std::filesystem::temp_directory_path() / "arpent_bench_tsdf.map";
  mapping::save_map(path, map);
  const auto size = std::filesystem::file_size(path);
  std::filesystem::remove(path);
  return static_cast<double>(size);
}

/// One view's gain: 40 x 32 rays from 0.3 to 5 m, as planning casts them; median over poses of the path.
double view_ms(const Truth& truth, const TsdfMap& map) {
  constexpr int kStridePx = 16;
  std::vector<double> times;
  const PinholeCamera camera = bench::workload_camera();
  for (int i = 0; i < bench::kPoses; i += 5) {
    const Pose T_map_cam = truth.room.T_map_scene() * bench::T_scene_cam_at(i);
    times.push_back(bench::cpu_ms([&] {
      for (int v = 0; v < camera.height_px; v += kStridePx) {
        for (int u = 0; u < camera.width_px; u += kStridePx) {
          const Eigen::Vector3d ray = T_map_cam.linear() * camera.unproject(u, v, 1.0).normalized();
          (void)mapping::cast_ray(map, T_map_cam.translation() + 0.3 * ray, ray, 4.7, 0.0);
        }
      }
    }));
  }
  return bench::median(times);
}

void measure(bench::Report& report, const Truth& truth, double voxel_m, const std::string& suffix) {
  const bool judged = voxel_m == 0.1;
  mapping::TsdfParams params;
  params.voxel_m = voxel_m;
  TsdfMap map(params);
  mapping::IncrementalMesher mesher;
  bench::DepthSequence depths(truth.room);
  std::vector<double> integration_ms, meshing_ms, reference_ms;
  for (int i = 0; i < bench::kPoses; ++i) {
    const stereo::DepthMap depth = depths.next();
    const Pose T_map_cam = truth.room.T_map_scene() * bench::T_scene_cam_at(i);
    if (i % kReferenceEvery == 0) reference_ms.push_back(bench::time_reference_once());
    integration_ms.push_back(bench::cpu_ms([&] { map.integrate(depth, T_map_cam); }));
    if (i + kMeshedFrames < bench::kPoses) continue;
    const double ms = bench::cpu_ms([&] { mesher.update(map); });
    if (i + kMeshedFrames > bench::kPoses) meshing_ms.push_back(ms);  // the first one meshes the whole map
  }
  const double reference = bench::median(reference_ms);
  report.add("tsdf.ms_per_frame" + suffix, bench::median(integration_ms), "ms");
  report.add("tsdf.ms_per_frame" + suffix + "_over_ref", bench::median(integration_ms) / reference, "1",
             judged ? "bar <= 0.07" : "");
  report.add("mesh.incremental_ms" + suffix, bench::median(meshing_ms), "ms");
  report.add("mesh.incremental_ms" + suffix + "_over_ref", bench::median(meshing_ms) / reference, "1",
             judged ? "bar <= 0.14" : "");
  measure_mesh(report, suffix, truth, mesher.mesh(), voxel_m);
  report.add("tsdf.false_ise" + suffix, count_false_ise(map), "1", "reported");
  report.add("tsdf.view_ms" + suffix, view_ms(truth, map), "ms", "1280 rays from 0.3 to 5 m");
  report.add("tsdf.map_mb" + suffix, static_cast<double>(map.block_count()) * sizeof(mapping::Block) / 1e6, "MB");
  report.add("map.bytes_per_m2" + suffix, bytes_on_disk(map) / truth.observed_m2, "B/m2", judged ? "bar <= 2000" : "");
}

void body(bench::Report& report) {
  const Truth truth = make_truth();
  report.add("tsdf.observed_m2", truth.observed_m2, "m2", "704.2 in the description of the workload");
  measure(report, truth, 0.1, "_r10");
  measure(report, truth, 0.2, "_r20");
  measure(report, truth, 0.05, "_r05");
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  return arpent::bench::run(argc, argv, "The map on a synthetic room", arpent::body);
}
