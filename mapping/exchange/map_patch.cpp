// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/exchange/map_patch.h"

#include <algorithm>
#include <cmath>

#include "mapping/exchange/block_code.h"

namespace arpent::mapping {
namespace {

/// w = sum w_p, phi = (sum w_p phi_p) / w, voxel by voxel.
void add_to(Block& block, const BlockUpdate& update, const TsdfParams& params) {
  const auto known_weight = static_cast<float>(params.known_weight), most = static_cast<float>(params.max_weight);
  block.known = 0;
  for (std::size_t i = 0; i < kBlockVoxels; ++i) {
    float& weight = block.weight[i];
    if (update.weight[i] > 0) {
      const float sum = weight + update.weight[i];
      block.distance_m[i] = (block.distance_m[i] * weight + update.distance_m[i] * update.weight[i]) / sum;
      weight = std::min(sum, most);
    }
    block.known += weight >= known_weight ? 1 : 0;
  }
}

bool same(double a, double b) {
  return std::abs(a - b) <= 1e-9 * std::abs(b);
}

}  // namespace

Result<std::size_t> fuse(TsdfMap& map, const MapPatch& patch) {
  TsdfMap::Storage& storage = map.storage();
  if (!same(patch.voxel_m, storage.params.voxel_m) || !same(patch.truncation_m, storage.truncation_m())) {
    return Fault{"a patch of another lattice"};
  }
  const auto updates = decode_blocks(patch.blocks, static_cast<float>(patch.truncation_m));
  if (!updates) return Fault{updates.fault()};
  ++storage.revision;
  for (const BlockUpdate& update : *updates) {
    const auto found = storage.by_index.find(update.index);
    std::unique_ptr<Block> fresh;
    if (found == storage.by_index.end()) {
      fresh = std::make_unique<Block>();
      fresh->index = update.index;
    }
    Block& block = fresh ? *fresh : *found->second;
    add_to(block, update, storage.params);
    block.revision = storage.revision;
    block.checksum_stale = true;
    if (fresh) storage.adopt(std::move(fresh));
  }
  return updates->size();
}

bool PatchLedger::add(const std::string& source, std::int64_t sequence) {
  Source& known = sources_[source];
  if (sequence < known.all_below || !known.beyond.insert(sequence).second) return false;
  while (!known.beyond.empty() && *known.beyond.begin() == known.all_below) {
    known.beyond.erase(known.beyond.begin());
    ++known.all_below;
  }
  return true;
}

std::int64_t PatchLedger::all_below(const std::string& source) const {
  const auto found = sources_.find(source);
  return found == sources_.end() ? 0 : found->second.all_below;
}

std::vector<std::int64_t> PatchLedger::missing(const std::string& source) const {
  std::vector<std::int64_t> missing;
  const auto found = sources_.find(source);
  if (found == sources_.end() || found->second.beyond.empty()) return missing;
  for (std::int64_t s = found->second.all_below; s < *found->second.beyond.rbegin(); ++s) {
    if (!found->second.beyond.contains(s)) missing.push_back(s);
  }
  return missing;
}

}  // namespace arpent::mapping
