// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/exchange/patch_builder.h"

#include <algorithm>
#include <tuple>

#include "common/config/config.h"
#include "mapping/exchange/block_code.h"

namespace arpent::mapping {
namespace {

constexpr double kStillM = 0.02;
constexpr double kStillRad = 0.02;

/// Neighbours lie together, whatever order they came in.
std::vector<const Block*> blocks_in_order(const TsdfMap& map) {
  std::vector<const Block*> blocks;
  for (const auto& block : map.storage().blocks) blocks.push_back(block.get());
  std::sort(blocks.begin(), blocks.end(), [](const Block* a, const Block* b) {
    return std::tuple(a->index.z(), a->index.y(), a->index.x()) < std::tuple(b->index.z(), b->index.y(), b->index.x());
  });
  return blocks;
}

}  // namespace

PatchBuilder::PatchBuilder(const PatchParams& params, const TsdfParams& tsdf, const std::string& source,
                           const std::string& frame)
    : params_(params), tsdf_(tsdf), open_(tsdf) {
  config::check(params, "patches");
  head_.source = source;
  head_.frame = frame;
  head_.voxel_m = tsdf.voxel_m;
  head_.truncation_m = open_.storage().truncation_m();
}

std::vector<MapPatch> PatchBuilder::add(const PosedDepth& image) {
  if (stands_too_long(image.body) || !open_.integrate(image.depth, image.T_map_cam)) return {};
  head_.newest = image.stamp;
  head_.bodies.push_back(image.body);
  head_.position_sigma_m = std::max(head_.position_sigma_m, image.position_sigma_m);
  head_.heading_sigma_rad = std::max(head_.heading_sigma_rad, image.heading_sigma_rad);
  if (static_cast<int>(head_.bodies.size()) < params_.images) return {};
  return close();
}

bool PatchBuilder::stands_too_long(const Pose2& body) {
  const bool stands = (body.position_m() - stood_at_.position_m()).norm() < kStillM &&
                      std::abs(wrap_angle(body.yaw_rad - stood_at_.yaw_rad)) < kStillRad;
  if (!stands) {
    stood_at_ = body;
    still_images_ = 0;
  }
  return ++still_images_ > params_.max_still_images;
}

std::vector<MapPatch> PatchBuilder::close() {
  const auto blocks = blocks_in_order(open_);
  std::vector<MapPatch> samples;
  for (auto& coded :
       encode_blocks(blocks, static_cast<float>(head_.truncation_m), static_cast<std::size_t>(params_.max_bytes))) {
    MapPatch sample = head_;
    sample.bodies.clear();
    sample.sequence = head_.sequence++;
    sample.blocks = std::move(coded);
    samples.push_back(std::move(sample));
  }
  if (!samples.empty()) samples.back().bodies = head_.bodies;
  head_.bodies.clear();
  head_.position_sigma_m = head_.heading_sigma_rad = 0;
  open_ = TsdfMap(tsdf_);
  return samples;
}

}  // namespace arpent::mapping
