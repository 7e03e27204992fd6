// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/artwork.h"

#include <fmt/format.h>

#include "calib/tag_code.h"
#include "common/error.h"

namespace arpent::calib {
namespace {

constexpr double kPointsPerM = 72 / 0.0254;  // PDF's unit is 1/72 inch
constexpr double kMarginM = 0.012;
constexpr double kFooterM = 0.018;

void add_tag(const Target& target, int tag, std::vector<BlackRectangle>& black) {
  const TagCode code(target.first_id + tag, target.border_cells);
  const double cell_m = target.tag_m / code.cells();
  const Eigen::Vector2d origin_m = target.corner_m(4 * tag);
  for (int row = 0; row < code.cells(); ++row) {
    // Runs of black cells in one piece: seams between rectangles show as hairlines on screens and in print.
    for (int begin = 0, end = 0; begin < code.cells(); begin = end + 1) {
      for (end = begin; end < code.cells() && code.is_black(row, end);) ++end;
      if (end == begin) continue;
      const double y_m = origin_m.y() + target.tag_m - (row + 1) * cell_m;
      black.push_back({origin_m.x() + begin * cell_m, y_m, (end - begin) * cell_m, cell_m});
    }
  }
}

std::vector<BlackRectangle> grid_rectangles(const Target& target) {
  std::vector<BlackRectangle> black;
  for (int tag = 0; tag < target.rows * target.columns; ++tag) add_tag(target, tag, black);
  const double gap_m = target.tag_m * target.spacing_ratio;
  for (int row = 0; row <= target.rows; ++row) {
    for (int column = 0; column <= target.columns; ++column) {
      black.push_back({column * target.tag_pitch_m() - gap_m, row * target.tag_pitch_m() - gap_m, gap_m, gap_m});
    }
  }
  return black;
}

std::string describe(const Target& target) {
  if (target.kind == TargetKind::kChessboard) {
    return fmt::format(
        "checkerboard  targetRows {}  targetCols {} (inner corners)  rowSpacingMeters {:g}  colSpacingMeters {:g}",
        target.rows, target.columns, target.row_m, target.column_m);
  }
  return fmt::format("aprilgrid 36h11  tagRows {}  tagCols {}  tagSize {:g} m  tagSpacing {:g}  tagBorder {}",
                     target.rows, target.columns, target.tag_m, target.spacing_ratio, target.border_cells);
}

std::string page_content(const Target& target, double left_m, double bottom_m) {
  std::string content = "0 g\n";
  const auto rectangle = [&](double x_m, double y_m, double width_m, double height_m) {
    content += fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} re\n", x_m * kPointsPerM, y_m * kPointsPerM,
                           width_m * kPointsPerM, height_m * kPointsPerM);
  };
  for (const BlackRectangle& r : black_rectangles(target)) {
    rectangle(left_m + r.x_m, bottom_m + r.y_m, r.width_m, r.height_m);
  }
  rectangle(kMarginM, kMarginM, 0.1, 0.001);
  rectangle(kMarginM, kMarginM - 0.002, 0.0005, 0.005);
  rectangle(kMarginM + 0.0995, kMarginM - 0.002, 0.0005, 0.005);
  content += "f\n";
  const auto text = [&](double y_m, const std::string& line) {
    content +=
        fmt::format("BT /F1 7 Tf {:.2f} {:.2f} Td ({}) Tj ET\n", kMarginM * kPointsPerM, y_m * kPointsPerM, line);
  };
  std::string escaped;
  for (const char c : describe(target)) {
    if (c == '(' || c == ')') escaped += '\\';
    escaped += c;
  }
  text(kMarginM + 0.008, escaped);
  text(kMarginM + 0.004, "This bar is 100.0 mm: measure it. If it is not, print again at 100 %, or correct the sizes.");
  return content;
}

}  // namespace

std::vector<BlackRectangle> black_rectangles(const Target& target) {
  if (target.kind == TargetKind::kAprilGrid) return grid_rectangles(target);
  std::vector<BlackRectangle> black;
  for (int row = -1; row < target.rows; ++row) {
    for (int column = -1; column < target.columns; ++column) {
      if ((row + column) % 2 != 0) continue;
      black.push_back({column * target.column_m, row * target.row_m, target.column_m, target.row_m});
    }
  }
  return black;
}

std::string board_pdf(const Target& target, double page_width_m, double page_height_m) {
  const Eigen::Vector2d size_m = target.size_m();
  if (size_m.x() + 2 * kMarginM > page_width_m || size_m.y() + 2 * kMarginM + kFooterM > page_height_m) {
    throw InputError(
        fmt::format("the board is {:.0f} x {:.0f} mm and does not fit a page of {:.0f} x {:.0f} mm with its margins",
                    1e3 * size_m.x(), 1e3 * size_m.y(), 1e3 * page_width_m, 1e3 * page_height_m));
  }
  const auto& black = black_rectangles(target);
  double low_x_m = 0, low_y_m = 0;
  for (const BlackRectangle& r : black) low_x_m = std::min(low_x_m, r.x_m), low_y_m = std::min(low_y_m, r.y_m);
  const std::string content = page_content(target, 0.5 * (page_width_m - size_m.x()) - low_x_m,
                                           page_height_m - kMarginM - size_m.y() - low_y_m);
  const std::vector<std::string> objects{
      "<< /Type /Catalog /Pages 2 0 R >>", "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      fmt::format(
          "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Contents 4 0 R /Resources << /Font << /F1 5 0 "
          "R >> >> >>",
          page_width_m * kPointsPerM, page_height_m * kPointsPerM),
      fmt::format("<< /Length {} >>\nstream\n{}endstream", content.size(), content),
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
  std::string pdf = "%PDF-1.4\n";
  std::string table = fmt::format("xref\n0 {}\n0000000000 65535 f \n", objects.size() + 1);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    table += fmt::format("{:010} 00000 n \n", pdf.size());
    pdf += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }
  const std::size_t table_at = pdf.size();
  return pdf + table +
         fmt::format("trailer\n<< /Size {} /Root 1 0 R >>\nstartxref\n{}\n%%EOF\n", objects.size() + 1, table_at);
}

}  // namespace arpent::calib
