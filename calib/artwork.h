// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a board looks like, as black rectangles on white: for the printed sheet (PDF, true to scale) and for anybody who
// draws pictures of it.
#pragma once

#include <string>
#include <vector>

#include "calib/target.h"

namespace arpent::calib {

/// A black rectangle in the board's plane (Target): lower left corner, width, height [m].
struct BlackRectangle {
  double x_m, y_m, width_m, height_m;
};

/// AprilGrid: the black cells of every tag and the black squares that fill the gaps' crossings, so that each corner of
/// a tag is the meeting point of two black and two white fields. Chessboard: the black squares; the field below left of
/// the first inner corner is black.
[[nodiscard]] std::vector<BlackRectangle> black_rectangles(const Target& target);

/// A one-page PDF (vectors only) of the page's size, true to scale, with a scale bar and the numbers of target.yaml
/// below the board. Throws InputError if the board with its margin does not fit the page.
[[nodiscard]] std::string board_pdf(const Target& target, double page_width_m, double page_height_m);

}  // namespace arpent::calib
