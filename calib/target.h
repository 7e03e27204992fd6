// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Calibration boards: Kalibr's AprilGrid and the chessboard, read from Kalibr's target.yaml. A board is a numbered set
// of corners in its own plane: x right, y up, z towards the one who looks at it, origin at the first corner.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace arpent::calib {

enum class TargetKind { kAprilGrid, kChessboard };

/// AprilGrid: tag `row * columns + column` of the family 36h11 (plus `first_id`), row 0 at the bottom; corner `4 * tag
/// + k` with k = bottom left, bottom right, top right, top left of the black square. Chessboard: `rows` x `columns`
/// inner corners, corner `row * columns + column`.
struct Target {
  TargetKind kind = TargetKind::kAprilGrid;
  int rows = 6;
  int columns = 6;
  // AprilGrid
  double tag_m = 0.088;        ///< outer edge of the black border
  double spacing_ratio = 0.3;  ///< gap between two tags over tag_m: a ratio, not metres
  int border_cells = 2;        ///< black cells around the 6 x 6 bits: 2 (Kalibr's boards) or 1 (the family's own)
  int first_id = 0;
  // chessboard
  double row_m = 0.03;
  double column_m = 0.03;

  [[nodiscard]] int corner_count() const { return (kind == TargetKind::kAprilGrid ? 4 : 1) * rows * columns; }
  [[nodiscard]] Eigen::Vector2d corner_m(int corner) const;
  /// Tag of a corner; AprilGrid only.
  [[nodiscard]] int tag_of(int corner) const { return first_id + corner / 4; }
  [[nodiscard]] double tag_pitch_m() const { return tag_m * (1 + spacing_ratio); }
  /// Width and height of the printed figure [m].
  [[nodiscard]] Eigen::Vector2d size_m() const;
};

/// Reads Kalibr's target.yaml (`target_type: aprilgrid` with tagRows, tagCols, tagSize, tagSpacing; `checkerboard` with
/// targetRows, targetCols, rowSpacingMeters, colSpacingMeters). Our own optional keys: tagBorder (1 or 2), firstId.
/// Throws InputError that lists every fault.
[[nodiscard]] Target load_target(const std::filesystem::path& file);
/// Every reason why a board cannot be, one line each.
[[nodiscard]] std::vector<std::string> find_faults(const Target& target);
/// target.yaml of a board; load_target reads it back.
[[nodiscard]] std::string to_yaml(const Target& target);

}  // namespace arpent::calib
