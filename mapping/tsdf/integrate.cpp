// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// TsdfMap::integrate: which blocks one depth image concerns, and what it says to each of their voxels (thesis
// Sect. 1.3.3, eq. 1.2 and 1.3).
#include <algorithm>
#include <cmath>

#include "common/parallel.h"
#include "mapping/tsdf/storage.h"
#include "mapping/tsdf/surface_cells.h"

namespace arpent::mapping {
namespace {

using Vector3f = Eigen::Vector3f;

constexpr float kMinDepthM = 0.05F;
/// Behind a surface a voxel is updated no farther along the ray than this many truncation distances: a plane seen
/// flatly is not followed for metres.
constexpr float kMaxBehindTruncations = 4.0F;
/// At edges, where no plane fits, nothing is said beyond this many voxels behind the pixel's depth.
constexpr float kEdgeBehindVoxels = 1.0F;
/// Farthest camera from the map's origin, in blocks: block indices stay far from overflow.
constexpr double kMaxBlocksFromOrigin = 1e6;
constexpr int kTileCells = 4;

/// Ranges of depth over tiles of 4 x 4 cells, to judge whole blocks.
struct Tiles {
  int cols = 0;
  int rows = 0;
  std::vector<float> most_m;  ///< 0 where nothing was measured
};

Tiles make_tiles(const SurfaceCells& cells) {
  Tiles tiles;
  tiles.cols = (cells.cols + kTileCells - 1) / kTileCells;
  tiles.rows = (cells.rows + kTileCells - 1) / kTileCells;
  tiles.most_m.assign(static_cast<std::size_t>(tiles.cols * tiles.rows), 0.0F);
  for (int v = 0; v < cells.rows; ++v) {
    for (int u = 0; u < cells.cols; ++u) {
      float& most = tiles.most_m[static_cast<std::size_t>((v / kTileCells) * tiles.cols + u / kTileCells)];
      most = std::max(most, cells.most_m[cells.at(u, v)]);
    }
  }
  return tiles;
}

/// Whether a pixel of the cell sees farther than the range of depth.
bool sees_beyond(const cv::Mat1f& depth_m, int cell_u, int cell_v, float max_range_m) {
  for (int v = cell_v * kCellPx; v < (cell_v + 1) * kCellPx; ++v) {
    const float* row = depth_m[v] + cell_u * kCellPx;
    for (int i = 0; i < kCellPx; ++i) {
      if (row[i] > max_range_m && std::isfinite(row[i])) return true;
    }
  }
  return false;
}

/// The cells of the image. Where it sees farther than the range of depth and there is no plane, its pixels are asked.
SurfaceCells make_cells(const stereo::DepthMap& depth, const TsdfParams& params) {
  SurfaceCells cells = fit_surface_cells(depth, params.min_range_m, params.max_range_m);
  const auto max_range_m = static_cast<float>(params.max_range_m);
  for (int v = 0; v < cells.rows; ++v) {
    for (int u = 0; u < cells.cols; ++u) {
      const std::size_t at = cells.at(u, v);
      if (cells.kinds[at] == CellKind::kPlane || !sees_beyond(depth.depth_m, u, v, max_range_m)) continue;
      cells.kinds[at] = CellKind::kEdge;
      cells.most_m[at] = max_range_m;
    }
  }
  return cells;
}

/// One depth image, ready to be asked.
class View {
 public:
  View(const stereo::DepthMap& depth, const Pose& T_map_cam, const TsdfMap::Storage& map)
      : depth_(depth),
        cells_(make_cells(depth, map.params)),
        tiles_(make_tiles(cells_)),
        T_cam_map_(T_map_cam.inverse()),
        camera_(depth.camera),
        voxel_m_(static_cast<float>(map.params.voxel_m)),
        truncation_m_(static_cast<float>(map.truncation_m())),
        nearest_m_(static_cast<float>(map.params.min_range_m)),
        farthest_m_(static_cast<float>(map.params.max_range_m)),
        max_weight_(static_cast<float>(map.params.max_weight)),
        known_weight_(static_cast<float>(map.params.known_weight)),
        block_edge_m_(map.block_edge_m()) {}

  /// The blocks that the image may concern, in a fixed order.
  [[nodiscard]] std::vector<BlockIndex> find_blocks(const Pose& T_map_cam) const;
  /// Fuses the image into the block. Returns whether anything changed.
  bool update(Block& block) const;

 private:
  [[nodiscard]] bool may_see(const BlockIndex& index) const;
  [[nodiscard]] float reach_m() const { return kMaxBehindTruncations * truncation_m_; }

  const stereo::DepthMap& depth_;
  SurfaceCells cells_;
  Tiles tiles_;
  Pose T_cam_map_;
  PinholeCamera camera_;
  float voxel_m_, truncation_m_, nearest_m_, farthest_m_, max_weight_, known_weight_;
  double block_edge_m_;
};

std::vector<BlockIndex> View::find_blocks(const Pose& T_map_cam) const {
  const double far_m = farthest_m_ + reach_m();
  Eigen::AlignedBox3d box(T_map_cam.translation());
  for (const double u : {-0.5, camera_.width_px - 0.5}) {
    for (const double v : {-0.5, camera_.height_px - 0.5}) box.extend(T_map_cam * camera_.unproject(u, v, far_m));
  }
  const BlockIndex least = (box.min() / block_edge_m_).array().floor().cast<int>();
  const BlockIndex most = (box.max() / block_edge_m_).array().floor().cast<int>();
  std::vector<BlockIndex> blocks;
  for (int z = least.z(); z <= most.z(); ++z) {
    for (int y = least.y(); y <= most.y(); ++y) {
      for (int x = least.x(); x <= most.x(); ++x) {
        if (may_see({x, y, z})) blocks.emplace_back(x, y, z);
      }
    }
  }
  return blocks;
}

/// False if the block is out of the image or wholly behind what is seen there.
bool View::may_see(const BlockIndex& index) const {
  const Eigen::Vector3d centre = T_cam_map_ * ((index.cast<double>().array() + 0.5) * block_edge_m_).matrix();
  const double radius = 0.5 * std::sqrt(3.0) * block_edge_m_;
  if (centre.z() + radius < kMinDepthM || centre.z() - radius > farthest_m_ + reach_m()) return false;
  int u0 = 0, u1 = tiles_.cols - 1, v0 = 0, v1 = tiles_.rows - 1;
  if (const double near_z = centre.z() - radius; near_z > kMinDepthM) {
    // The sphere's image lies within these bounds: each side's slope is taken at the nearest depth.
    const auto bound = [&](double x, double f, double c, int last, int& low, int& high) {
      const double lower = x - radius;
      const double upper = x + radius;
      const double far_z = centre.z() + radius;
      const double least = f * lower / (lower < 0 ? near_z : far_z) + c;
      const double most = f * upper / (upper > 0 ? near_z : far_z) + c;
      low = std::max(0, static_cast<int>(std::floor(std::max(least, 0.0))) / (kCellPx * kTileCells));
      high = std::min(last, static_cast<int>(std::floor(std::min(most, 1e5))) / (kCellPx * kTileCells));
      return most >= 0;
    };
    if (!bound(centre.x(), camera_.fx_px, camera_.cx_px, u1, u0, u1)) return false;
    if (!bound(centre.y(), camera_.fy_px, camera_.cy_px, v1, v0, v1)) return false;
  }
  float most = 0;
  for (int v = v0; v <= v1; ++v) {
    for (int u = u0; u <= u1; ++u) most = std::max(most, tiles_.most_m[static_cast<std::size_t>(v * tiles_.cols + u)]);
  }
  return most > 0 && centre.z() - radius <= static_cast<double>(most + reach_m());
}

bool View::update(Block& block) const {
  const Eigen::Matrix3f R = T_cam_map_.linear().cast<float>();
  const Vector3f step = R.col(0) * voxel_m_;
  const Eigen::Vector3d corner_map = block.index.cast<double>() * block_edge_m_;
  const Vector3f corner = (T_cam_map_ * corner_map).cast<float>();
  const auto fx = static_cast<float>(camera_.fx_px), fy = static_cast<float>(camera_.fy_px);
  const auto cx = static_cast<float>(camera_.cx_px) + 0.5F, cy = static_cast<float>(camera_.cy_px) + 0.5F;
  const auto width = static_cast<float>(cells_.cols * kCellPx), height = static_cast<float>(cells_.rows * kCellPx);
  const float drop_start = -0.5F * voxel_m_;
  const float drop_scale = 1.0F / (truncation_m_ + drop_start);
  bool changed = false;
  int known = 0;
  for (int row = 0; row < kBlockSide * kBlockSide; ++row) {
    Vector3f p = corner + R * (voxel_m_ * Vector3f(0.5F, static_cast<float>(row % kBlockSide) + 0.5F,
                                                   static_cast<float>(row / kBlockSide) + 0.5F));
    float* distances = &block.distance_m[static_cast<std::size_t>(row * kBlockSide)];
    float* weights = &block.weight[static_cast<std::size_t>(row * kBlockSide)];
    for (int i = 0; i < kBlockSide; ++i, p += step) {
      known += weights[i] >= known_weight_ ? 1 : 0;
      if (p.z() < kMinDepthM) continue;
      const float iz = 1.0F / p.z();
      const float u = fx * p.x() * iz + cx;
      const float v = fy * p.y() * iz + cy;
      if (!(u >= 0 && v >= 0 && u < width && v < height)) continue;
      const int pixel_u = static_cast<int>(u);
      const int pixel_v = static_cast<int>(v);
      const std::size_t at = cells_.at(pixel_u / kCellPx, pixel_v / kCellPx);
      float distance = 0;
      const CellKind kind = cells_.kinds[at];
      if (kind == CellKind::kPlane) {
        const Cell& plane = cells_.planes[at];
        distance = plane.nx * p.x() + plane.ny * p.y() + plane.nz * p.z() + plane.offset_m;
        if (distance <= -truncation_m_) continue;  // there the weight is 0
        if (distance < 0) {
          const float surface_z = plane.offset_m * p.z() / (plane.offset_m - distance);
          if (p.z() - surface_z > reach_m()) continue;
        }
      } else if (kind == CellKind::kEdge) {
        const float z = depth_.depth_m(pixel_v, pixel_u);
        // A surface beyond the range of depth is not measured, but up to there nothing is in the way.
        if (!(z >= nearest_m_ && std::min(z, p.z()) <= farthest_m_) || !std::isfinite(z)) continue;
        distance = z - p.z();
        if (distance <= -std::min(kEdgeBehindVoxels * voxel_m_, truncation_m_)) continue;
      } else {
        continue;
      }
      float weight = 1.0F / p.squaredNorm();
      if (distance < drop_start) weight *= (truncation_m_ + distance) * drop_scale;
      const float sum = weights[i] + weight;
      const float before = weights[i];
      distances[i] = (distances[i] * before + std::min(distance, truncation_m_) * weight) / sum;  // eq. 1.2
      weights[i] = std::min(sum, max_weight_);
      known += before < known_weight_ && weights[i] >= known_weight_ ? 1 : 0;
      changed = true;
    }
  }
  block.known = known;
  return changed;
}

bool usable(const stereo::DepthMap& depth, const Pose& T_map_cam, double block_edge_m) {
  return T_map_cam.matrix().allFinite() &&
         (T_map_cam.translation() / block_edge_m).cwiseAbs().maxCoeff() < kMaxBlocksFromOrigin &&
         (T_map_cam.linear() * T_map_cam.linear().transpose()).isIdentity(1e-3) &&
         depth.depth_m.size() == depth.sigma_m.size() && depth.depth_m.cols == depth.camera.width_px &&
         depth.depth_m.rows == depth.camera.height_px && depth.camera.fx_px > 0 && depth.camera.fy_px > 0;
}

}  // namespace

bool TsdfMap::integrate(const stereo::DepthMap& depth, const Pose& T_map_cam) {
  Storage& map = *storage_;
  if (!usable(depth, T_map_cam, map.block_edge_m())) return false;
  ++map.revision;
  const View view(depth, T_map_cam, map);
  const std::vector<BlockIndex> indices = view.find_blocks(T_map_cam);
  // New blocks are made aside and join the map only if something was said to them.
  std::vector<Block*> blocks;
  std::vector<std::unique_ptr<Block>> fresh(indices.size());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const auto found = map.by_index.find(indices[i]);
    if (found == map.by_index.end()) {
      fresh[i] = std::make_unique<Block>();
      fresh[i]->index = indices[i];
    }
    blocks.push_back(fresh[i] ? fresh[i].get() : found->second);
  }
  std::vector<std::uint8_t> changed(indices.size());
  parallel_for(map.params.threads, static_cast<int>(indices.size()), [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      changed[i] = view.update(*blocks[i]) ? 1 : 0;
    }
  });
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (changed[i] == 0) continue;
    blocks[i]->revision = map.revision;
    blocks[i]->checksum_stale = true;
    if (fresh[i]) map.adopt(std::move(fresh[i]));
  }
  return true;
}

}  // namespace arpent::mapping
