// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/ground_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "common/config/config.h"
#include "common/error.h"
#include "mapping/tsdf/storage.h"

namespace arpent::planning {
namespace {

/// A body in the map is up to a voxel larger than it is.
constexpr double kBodyMarginM = 0.15;

using mapping::kBlockSide;

constexpr int kTileCells = 16;
/// The grid grows by this much more than it has to, so that it seldom does.
constexpr int kSpareBlocks = 4;
constexpr int kUnknownRing = 2;
constexpr double kMaxSideM = 1000.0;

int floor_div(int value, int divisor) {
  return value >= 0 ? value / divisor : -((divisor - 1 - value) / divisor);
}

}  // namespace

GroundGrid::GroundGrid(const GroundGridParams& params) : params_(params) {
  config::check(params, "ground grid");
  frame_.cell_m = params.cell_m;
}

void GroundGrid::declare_free(const Eigen::Vector2d& centre_m, double radius_m) {
  ARPENT_ASSERT(centre_m.allFinite() && radius_m > 0 && radius_m < kMaxSideM);
  discs_.push_back({centre_m, radius_m});
  judge_around(centre_m, radius_m);
}

void GroundGrid::declare_body(const Footprint& footprint, const Pose2& pose) {
  bodies_.push_back({footprint, pose});
  judge_around(pose.position_m(), footprint.long_m() + kBodyMarginM);
}

void GroundGrid::judge_around(const Eigen::Vector2d& centre_m, double reach_m) {
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(reach_m);
  cover_cells({centre_m - reach, centre_m + reach});
  ++revision_;
  (void)judge({frame_.cell_of(centre_m - reach), frame_.cell_of(centre_m + reach)});
}

GroundGrid::Cell GroundGrid::cell_at(const Eigen::Vector2d& p_m) const {
  const Eigen::Vector2i cell = frame_.cell_of(p_m) + frame_.first;
  return {cell.x(), cell.y()};
}

Eigen::Vector2d GroundGrid::centre_m(const Cell& cell) const {
  return frame_.centre_m(cell.first - frame_.first.x(), cell.second - frame_.first.y());
}

void GroundGrid::mark(const Cell& cell, bool occupied) {
  const bool changed = occupied ? marked_.insert(cell).second : marked_.erase(cell) > 0;
  if (changed) judge_around(centre_m(cell), 0);
}

std::size_t GroundGrid::update(const mapping::TsdfMap& map) {
  const double voxel_m = map.params().voxel_m;
  if (map.revision() < map_revision_ || voxel_m != voxel_m_) forget();
  voxel_m_ = voxel_m;
  last_layer_ = static_cast<int>(std::floor(params_.robot_height_m / voxel_m - 0.5 + 1e-9));
  if (last_layer_ < first_layer_) throw InputError("ground grid: robot_height_m must reach the second layer of voxels");

  // Blocks in the set's order: the result does not depend on the order in which the map came to be.
  const int least_z = mapping::floor_div8(first_layer_), most_z = mapping::floor_div8(last_layer_);
  std::set<std::pair<int, int>> changed;
  for (const auto& block : map.storage().blocks) {
    if (block->index.z() < least_z || block->index.z() > most_z || block->revision <= map_revision_) continue;
    changed.emplace(block->index.y(), block->index.x());
  }
  map_revision_ = map.revision();
  if (changed.empty()) return 0;

  Box columns{Eigen::Vector2i::Constant(INT32_MAX), Eigen::Vector2i::Constant(INT32_MIN)};
  for (const auto& [y, x] : changed) {
    columns.least = columns.least.cwiseMin(Eigen::Vector2i(x, y) * kBlockSide);
    columns.most =
        columns.most.cwiseMax(Eigen::Vector2i(x, y) * kBlockSide + Eigen::Vector2i::Constant(kBlockSide - 1));
  }
  cover(columns);
  for (const auto& [y, x] : changed) read_columns(map, {x, y});
  ++revision_;
  std::size_t count = 0;
  for (const auto& [y, x] : changed) {
    // Interpolation reaches one voxel into the neighbouring blocks.
    const Eigen::Vector2d least = (Eigen::Vector2d(x, y) * kBlockSide - Eigen::Vector2d::Ones()) * voxel_m;
    const Eigen::Vector2d most = (Eigen::Vector2d(x + 1, y + 1) * kBlockSide + Eigen::Vector2d::Ones()) * voxel_m;
    count += judge({frame_.cell_of(least), frame_.cell_of(most)});
  }
  return count;
}

CellState GroundGrid::state(const Eigen::Vector2d& p_m) const {
  const Eigen::Vector2i cell = frame_.cell_of(p_m);
  return frame_.has(cell.x(), cell.y()) ? states_[frame_.at(cell.x(), cell.y())] : CellState::kUnknown;
}

bool GroundGrid::changed_since(const GroundBox& box, std::int64_t revision) const {
  const auto tile = [&](double metres) {
    return floor_div(static_cast<int>(std::floor(metres / frame_.cell_m)), kTileCells);
  };
  return std::any_of(tile_changed_at_.begin(), tile_changed_at_.end(), [&](const auto& entry) {
    const auto& [at, changed_at] = entry;
    return changed_at > revision && at.first >= tile(box.least_m.x()) && at.first <= tile(box.most_m.x()) &&
           at.second >= tile(box.least_m.y()) && at.second <= tile(box.most_m.y());
  });
}

/// What the map said; declarations stay.
void GroundGrid::forget() {
  columns_.clear();
  columns_x_ = columns_y_ = 0;
  map_revision_ = -1;
  if (frame_.size() == 0) return;
  ++revision_;
  (void)judge({Eigen::Vector2i::Zero(), Eigen::Vector2i(frame_.cols - 1, frame_.rows - 1)});
}

/// Makes room for these columns, and for the cells above them.
void GroundGrid::cover(const Box& columns) {
  if (columns_.empty() || !has_column(columns.least.x(), columns.least.y()) ||
      !has_column(columns.most.x(), columns.most.y())) {
    const Eigen::Vector2i spare = Eigen::Vector2i::Constant(kSpareBlocks * kBlockSide);
    Eigen::Vector2i least = columns.least - spare, most = columns.most + spare;
    if (!columns_.empty()) {
      least = least.cwiseMin(first_column_);
      most = most.cwiseMax(first_column_ + Eigen::Vector2i(columns_x_ - 1, columns_y_ - 1));
    }
    const Eigen::Vector2i size = most - least + Eigen::Vector2i::Ones();
    if (size.maxCoeff() * voxel_m_ > kMaxSideM) throw InputError("ground grid: the map is larger than 1 km");
    std::vector<Column> wider(static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()));
    for (int y = 0; y < columns_y_; ++y) {
      const Eigen::Vector2i to = first_column_ + Eigen::Vector2i(0, y) - least;
      const auto row = columns_.begin() + static_cast<std::ptrdiff_t>(y) * columns_x_;
      std::copy(row, row + columns_x_, wider.begin() + static_cast<std::ptrdiff_t>(to.y()) * size.x() + to.x());
    }
    columns_ = std::move(wider);
    first_column_ = least;
    columns_x_ = size.x();
    columns_y_ = size.y();
  }
  cover_cells(columns_box());
}

void GroundGrid::cover_cells(const GroundBox& box) {
  const Eigen::Vector2i ring = Eigen::Vector2i::Constant(kUnknownRing);
  Eigen::Vector2i least = (box.least_m / frame_.cell_m).array().floor().cast<int>().matrix() - ring;
  Eigen::Vector2i most = (box.most_m / frame_.cell_m).array().floor().cast<int>().matrix() + ring;
  if (frame_.size() > 0) {
    const Eigen::Vector2i last = frame_.first + Eigen::Vector2i(frame_.cols - 1, frame_.rows - 1);
    if ((least.array() >= frame_.first.array()).all() && (most.array() <= last.array()).all()) return;
    least = least.cwiseMin(frame_.first);
    most = most.cwiseMax(last);
  }
  GridFrame wider{frame_.cell_m, least, most.x() - least.x() + 1, most.y() - least.y() + 1};
  std::vector<CellState> states(wider.size(), CellState::kUnknown);
  for (int j = 0; j < frame_.rows; ++j) {
    const Eigen::Vector2i to = frame_.first + Eigen::Vector2i(0, j) - least;
    const auto row = states_.begin() + static_cast<std::ptrdiff_t>(frame_.at(0, j));
    std::copy(row, row + frame_.cols, states.begin() + static_cast<std::ptrdiff_t>(wider.at(to.x(), to.y())));
  }
  frame_ = wider;
  states_ = std::move(states);
}

void GroundGrid::read_columns(const mapping::TsdfMap& map, const Eigen::Vector2i& block_xy) {
  const auto known_weight = static_cast<float>(map.params().known_weight);
  std::array<Column, kBlockSide * kBlockSide> fresh;
  std::array<int, kBlockSide * kBlockSide> known{};
  for (int z = mapping::floor_div8(first_layer_); z <= mapping::floor_div8(last_layer_); ++z) {
    const mapping::Block* block = map.storage().find({block_xy.x(), block_xy.y(), z});
    if (block == nullptr) continue;
    for (int layer = std::max(first_layer_, z * kBlockSide); layer <= std::min(last_layer_, z * kBlockSide + 7);
         ++layer) {
      const auto slice = static_cast<std::size_t>((layer & 7) * kBlockSide * kBlockSide);
      for (std::size_t i = 0; i < fresh.size(); ++i) {
        if (block->weight[slice + i] < known_weight) continue;
        const float d = block->distance_m[slice + i];
        fresh[i].distance_m = fresh[i].seen ? std::min(fresh[i].distance_m, d) : d;
        fresh[i].seen = true;
        ++known[i];
      }
    }
  }
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    fresh[i].known = known[i] == last_layer_ - first_layer_ + 1;
    const Eigen::Vector2i at =
        block_xy * kBlockSide - first_column_ + Eigen::Vector2i(static_cast<int>(i) & 7, static_cast<int>(i) >> 3);
    columns_[static_cast<std::size_t>(at.y()) * static_cast<std::size_t>(columns_x_) +
             static_cast<std::size_t>(at.x())] = fresh[i];
  }
}

std::size_t GroundGrid::judge(const Box& cells) {
  std::size_t count = 0;
  const int ring = kUnknownRing;
  for (int j = std::max(ring, cells.least.y()); j <= std::min(frame_.rows - 1 - ring, cells.most.y()); ++j) {
    for (int i = std::max(ring, cells.least.x()); i <= std::min(frame_.cols - 1 - ring, cells.most.x()); ++i) {
      const Eigen::Vector2d centre_m = frame_.centre_m(i, j);
      const bool marked = !marked_.empty() && marked_.contains({frame_.first.x() + i, frame_.first.y() + j});
      const CellState state = marked && !is_body(centre_m) ? CellState::kOccupied : judge(centre_m);
      CellState& held = states_[frame_.at(i, j)];
      if (state == held) continue;
      held = state;
      ++count;
      tile_changed_at_[{floor_div(frame_.first.x() + i, kTileCells), floor_div(frame_.first.y() + j, kTileCells)}] =
          revision_;
    }
  }
  return count;
}

bool GroundGrid::is_body(const Eigen::Vector2d& p_m) const {
  return std::any_of(bodies_.begin(), bodies_.end(),
                     [&](const Body& b) { return b.footprint.contains(b.pose, p_m, kBodyMarginM); });
}

CellState GroundGrid::judge(const Eigen::Vector2d& p_m) const {
  if (is_body(p_m)) return CellState::kFree;
  const bool declared = std::any_of(discs_.begin(), discs_.end(), [&](const Disc& disc) {
    return (disc.centre_m - p_m).squaredNorm() <= disc.radius_m * disc.radius_m;
  });
  const CellState otherwise = declared ? CellState::kFree : CellState::kUnknown;
  if (columns_.empty()) return otherwise;
  const Eigen::Vector2i voxel = (p_m / voxel_m_).array().floor().cast<int>();
  const Column own = column(voxel.x(), voxel.y());
  if (!own.seen) return otherwise;
  // A surface that passes through the cell is at most this far from its centre, or just beyond in the corners.
  if (interpolate_m(p_m, own) <= 0.5 * frame_.cell_m) return CellState::kOccupied;
  return own.known ? CellState::kFree : otherwise;
}

bool GroundGrid::has_column(int i, int j) const {
  const int x = i - first_column_.x(), y = j - first_column_.y();
  return x >= 0 && y >= 0 && x < columns_x_ && y < columns_y_;
}

GroundGrid::Column GroundGrid::column(int i, int j) const {
  if (!has_column(i, j)) return {};
  return columns_[static_cast<std::size_t>(j - first_column_.y()) * static_cast<std::size_t>(columns_x_) +
                  static_cast<std::size_t>(i - first_column_.x())];
}

/// Bilinear between the four columns around; one that was never seen counts as the own one.
double GroundGrid::interpolate_m(const Eigen::Vector2d& p_m, const Column& own) const {
  const Eigen::Vector2d p = p_m / voxel_m_ - Eigen::Vector2d::Constant(0.5);
  const Eigen::Vector2d base = p.array().floor();
  const Eigen::Vector2d t = p - base;
  double sum = 0;
  for (int n = 0; n < 4; ++n) {
    const int dx = n & 1, dy = n >> 1;
    const Column corner = column(static_cast<int>(base.x()) + dx, static_cast<int>(base.y()) + dy);
    const double weight = (dx == 1 ? t.x() : 1 - t.x()) * (dy == 1 ? t.y() : 1 - t.y());
    sum += weight * static_cast<double>(corner.seen ? corner.distance_m : own.distance_m);
  }
  return sum;
}

GroundBox GroundGrid::columns_box() const {
  return {first_column_.cast<double>() * voxel_m_,
          (first_column_ + Eigen::Vector2i(columns_x_, columns_y_)).cast<double>() * voxel_m_};
}

}  // namespace arpent::planning
