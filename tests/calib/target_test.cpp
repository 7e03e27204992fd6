// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/target.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "calib/artwork.h"
#include "common/error.h"

namespace arpent::calib {
namespace {

using testing::HasSubstr;

Target load_text(const std::string& yaml) {
  const auto file = std::filesystem::temp_directory_path() / ("target_test_" + std::to_string(getpid()) + ".yaml");
  std::ofstream(file) << yaml;
  const struct Remover {
    std::filesystem::path path;
    ~Remover() { std::filesystem::remove(path); }
  } remover{file};
  return load_target(file);
}

std::string fault_of(const std::string& yaml) {
  try {
    (void)load_text(yaml);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

TEST(CalibTarget, ReadsKalibrsAprilGrid) {
  const Target t = load_text("target_type: 'aprilgrid'\ntagCols: 7\ntagRows: 5\ntagSize: 0.08\ntagSpacing: 0.25\n");
  EXPECT_EQ(t.kind, TargetKind::kAprilGrid);
  EXPECT_EQ(t.columns, 7);
  EXPECT_EQ(t.rows, 5);
  EXPECT_EQ(t.border_cells, 2);
  EXPECT_EQ(t.corner_count(), 140);
  // Tag 8 is the second of the second row: one pitch of 0.08 * 1.25 = 0.1 m right and up; its corner 2 a tag further.
  EXPECT_NEAR((t.corner_m(4 * 8 + 0) - Eigen::Vector2d(0.1, 0.1)).norm(), 0, 1e-12);
  EXPECT_NEAR((t.corner_m(4 * 8 + 2) - Eigen::Vector2d(0.18, 0.18)).norm(), 0, 1e-12);
}

TEST(CalibTarget, ReadsKalibrsCheckerboard) {
  const Target t = load_text(
      "target_type: checkerboard\ntargetCols: 9\ntargetRows: 6\nrowSpacingMeters: 0.03\ncolSpacingMeters: 0.02\n");
  EXPECT_EQ(t.corner_count(), 54);
  EXPECT_NEAR((t.corner_m(9 + 2) - Eigen::Vector2d(0.04, 0.03)).norm(), 0, 1e-12);
}

TEST(CalibTarget, NamesEveryFault) {
  const std::string fault = fault_of("target_type: aprilgrid\ntagRows: six\ntagSize: 0.08\ntagspacing: 0.3\n");
  EXPECT_THAT(fault, HasSubstr("tagRows is no whole number"));
  EXPECT_THAT(fault, HasSubstr("tagCols is missing"));
  EXPECT_THAT(fault, HasSubstr("tagSpacing is missing"));
  EXPECT_THAT(fault, HasSubstr("tagspacing is no key"));
  EXPECT_THAT(fault_of("target_type: circlegrid\n"), HasSubstr("aprilgrid or checkerboard"));
  EXPECT_THAT(fault_of("target_type: aprilgrid\ntagRows: 30\ntagCols: 30\ntagSize: 0.08\ntagSpacing: 0.3\n"),
              HasSubstr("587"));
}

TEST(CalibTarget, IsReadBackAsItWasWritten) {
  Target grid;
  grid.rows = 4;
  grid.columns = 5;
  grid.border_cells = 1;
  grid.first_id = 10;
  const Target again = load_text(to_yaml(grid));
  EXPECT_EQ(to_yaml(again), to_yaml(grid));
  Target chess;
  chess.kind = TargetKind::kChessboard;
  EXPECT_EQ(to_yaml(load_text(to_yaml(chess))), to_yaml(chess));
}

TEST(CalibArtwork, EveryTagCornerIsAMeetingOfTwoBlackAndTwoWhiteFields) {
  const Target target;
  const auto black = black_rectangles(target);
  const auto is_black = [&](const Eigen::Vector2d& p) {
    return std::any_of(black.begin(), black.end(), [&](const BlackRectangle& r) {
      return p.x() > r.x_m && p.x() < r.x_m + r.width_m && p.y() > r.y_m && p.y() < r.y_m + r.height_m;
    });
  };
  for (int corner = 0; corner < target.corner_count(); ++corner) {
    const Eigen::Vector2d p = target.corner_m(corner);
    const double d = 0.2 * target.tag_m * target.spacing_ratio;
    const bool rising = is_black(p + Eigen::Vector2d(d, d));
    EXPECT_EQ(is_black(p - Eigen::Vector2d(d, d)), rising) << corner;
    EXPECT_EQ(is_black(p + Eigen::Vector2d(d, -d)), !rising) << corner;
    EXPECT_EQ(is_black(p + Eigen::Vector2d(-d, d)), !rising) << corner;
  }
}

TEST(CalibArtwork, ThePdfIsWellFormedAndTrueToScale) {
  Target target;
  target.kind = TargetKind::kChessboard;
  target.rows = 3;
  target.columns = 4;
  target.row_m = target.column_m = 0.0254;
  const std::string pdf = board_pdf(target, 0.297, 0.210);
  // The table of objects says where each begins.
  const std::size_t table = pdf.find("xref\n");
  for (int object = 1; object <= 5; ++object) {
    const std::size_t at = std::stoul(pdf.substr(table + 9 + static_cast<std::size_t>(20 * object), 10));
    EXPECT_EQ(pdf.substr(at, 7), std::to_string(object) + " 0 obj");
  }
  EXPECT_EQ(std::stoul(pdf.substr(pdf.find("startxref\n") + 10)), table);
  // A field of one inch is 72 points; 4 x 5 fields, half of them black.
  std::size_t fields = 0;
  for (std::size_t at = 0; (at = pdf.find(" 72.0000 72.0000 re\n", at)) != std::string::npos; ++at) ++fields;
  EXPECT_EQ(fields, 10U);
  EXPECT_THROW((void)board_pdf(target, 0.10, 0.10), InputError);
}

}  // namespace
}  // namespace arpent::calib
