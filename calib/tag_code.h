// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The cells of a tag of the family 36h11 with a black border of one or two cells.
#pragma once

#include <vector>

namespace arpent::calib {

class TagCode {
 public:
  /// Aborts for an id that the family does not have, or another border than 1 or 2.
  TagCode(int id, int border_cells);
  /// Cells along a side, border included: 8 or 10.
  [[nodiscard]] int cells() const { return cells_; }
  /// Row 0 is the top one.
  [[nodiscard]] bool is_black(int row, int column) const {
    return black_[static_cast<std::size_t>(row * cells_ + column)];
  }

 private:
  int cells_;
  std::vector<bool> black_;
};

}  // namespace arpent::calib
