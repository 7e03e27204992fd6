// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The ground as the map knows it: per cell free, occupied or unknown, from the voxels of a band between the floor
// (z = 0) and the robot's height; outside of the band nothing counts. Cells are finer than voxels: the surface is put
// where the interpolated distances say, so that coarse voxels do not close narrow gaps. Kept up to date by the map's
// changed blocks. It does not know the robot's footprint (ground.h).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/config/fields.h"
#include "mapping/tsdf/tsdf_map.h"
#include "planning/local/footprint.h"
#include "planning/local/grid_frame.h"

namespace arpent::planning {

struct GroundGridParams {
  double cell_m = 0.05;
  double robot_height_m = 0.6;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("cell_m", self.cell_m, "edge of a cell of the ground", config::between(0.01, 0.5));
    visitor.field("robot_height_m", self.robot_height_m, "what is higher above the floor does not hinder the robot",
                  config::between(0.1, 5.0));
  }
};

enum class CellState : std::uint8_t { kUnknown, kFree, kOccupied };

/// A rectangle on the ground, map frame.
struct GroundBox {
  Eigen::Vector2d least_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d most_m = Eigen::Vector2d::Zero();
};

class GroundGrid {
 public:
  /// Throws InputError for parameters that break their rules.
  explicit GroundGrid(const GroundGridParams& params);

  /// Declares a disc free until depth says otherwise: the start, which a forward camera never sees (thesis
  /// Table 5.3 is silent; a mission's start clearance).
  void declare_free(const Eigen::Vector2d& centre_m, double radius_m);

  /// Declares free where a robot stands, whatever the map says: others that saw it before it joined them took it for
  /// surface.
  void declare_body(const Footprint& footprint, const Pose2& pose);

  /// A cell by its place in the map: it covers [first, first + 1) times the cell's edge along x, and so on.
  using Cell = std::pair<int, int>;
  [[nodiscard]] Cell cell_at(const Eigen::Vector2d& p_m) const;
  [[nodiscard]] Eigen::Vector2d centre_m(const Cell& cell) const;
  /// A marked cell is occupied, whatever the map says (fresh_obstacles.h), unless a body was declared there.
  void mark(const Cell& cell, bool occupied);
  /// Without marks.
  [[nodiscard]] CellState mapped_state(const Cell& cell) const { return judge(centre_m(cell)); }

  /// Takes over what changed in the map since the last call (all of it the first time, or if the map's revision went
  /// back). A column of voxels is free if all its voxels in the band (centres from one voxel above the floor up to
  /// the robot's height) are known and empty. Returns the number of cells whose state changed. Throws InputError if no
  /// voxel centre lies in the band.
  std::size_t update(const mapping::TsdfMap& map);

  /// The two outermost rings of cells are always unknown.
  [[nodiscard]] const GridFrame& frame() const { return frame_; }
  [[nodiscard]] const std::vector<CellState>& states() const { return states_; }
  [[nodiscard]] CellState state(const Eigen::Vector2d& p_m) const;
  /// Grows with every update or declaration that changed a cell.
  [[nodiscard]] std::int64_t revision() const { return revision_; }
  /// Whether the state of a cell in the box (to within a tile of 16 cells) changed after `revision`.
  [[nodiscard]] bool changed_since(const GroundBox& box, std::int64_t revision) const;

 private:
  /// What the band's voxels of one column say.
  struct Column {
    float distance_m = 0;  ///< least of the known voxels
    bool seen = false;     ///< one of the voxels is known
    bool known = false;    ///< all of them are
  };
  struct Disc {
    Eigen::Vector2d centre_m;
    double radius_m;
  };
  struct Body {
    Footprint footprint;
    Pose2 pose;
  };
  struct Box {
    Eigen::Vector2i least, most;  ///< both within
  };

  void forget();
  void cover(const Box& columns);
  void judge_around(const Eigen::Vector2d& centre_m, double reach_m);
  void cover_cells(const GroundBox& box);
  void read_columns(const mapping::TsdfMap& map, const Eigen::Vector2i& block);
  std::size_t judge(const Box& cells);
  [[nodiscard]] CellState judge(const Eigen::Vector2d& p_m) const;
  [[nodiscard]] bool is_body(const Eigen::Vector2d& p_m) const;
  [[nodiscard]] bool has_column(int i, int j) const;
  [[nodiscard]] Column column(int i, int j) const;
  [[nodiscard]] double interpolate_m(const Eigen::Vector2d& p_m, const Column& own) const;
  [[nodiscard]] GroundBox columns_box() const;

  GroundGridParams params_;
  std::vector<Disc> discs_;
  std::vector<Body> bodies_;
  std::set<Cell> marked_;
  double voxel_m_ = 0;  ///< 0 before the first update
  int first_layer_ = 1, last_layer_ = 0;
  std::int64_t map_revision_ = -1;
  Eigen::Vector2i first_column_ = Eigen::Vector2i::Zero();
  int columns_x_ = 0, columns_y_ = 0;
  std::vector<Column> columns_;
  GridFrame frame_;
  std::vector<CellState> states_;
  std::int64_t revision_ = 0;
  std::map<std::pair<int, int>, std::int64_t> tile_changed_at_;
};

}  // namespace arpent::planning
