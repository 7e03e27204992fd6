// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/obstacles.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

GroundGrid room_grid() {
  GroundGrid grid({});
  const auto map = make_map(FlatWorld{}, 0.1);
  (void)grid.update(map);
  return grid;
}

TEST(BodiesOnTheGround, ATeammateTakesItsEllipseAndTheGapAndNothingElse) {
  const GroundGrid grid = room_grid();
  const Footprint footprint{FootprintParams{}};
  const Pose2 mate{4, 3.5, 0.7};
  const Ground ground = ground_with_bodies(grid, footprint, {}, {&mate, 1}, footprint, 0.1, {1, 1, 0});
  for (double x = 2.5; x < 5.5; x += 0.05) {
    for (double y = 2; y < 5; y += 0.05) {
      const Eigen::Vector2d centre =
          ground.frame().centre_m(ground.frame().cell_of({x, y}).x(), ground.frame().cell_of({x, y}).y());
      EXPECT_EQ(ground.state({x, y}) == CellState::kOccupied, footprint.contains(mate, centre, 0.1)) << x << ' ' << y;
    }
  }
}

TEST(BodiesOnTheGround, ARobotCloseToATeammateCanStillDriveOff) {
  const GroundGrid grid = room_grid();
  const Footprint footprint{FootprintParams{}};
  const Pose2 own{4, 3.5, 0}, mate{4, 3.5 + 0.53, 0};  // flank to flank, 3 cm apart
  const Ground ground = ground_with_bodies(grid, footprint, {}, {&mate, 1}, footprint, 0.1, own);
  EXPECT_GE(ground.margin_m(own), -0.09) << "what it covers itself is not stamped";
  EXPECT_FALSE(ground.is_free({4, 3.7, 0}));
}

TEST(BodiesOnTheGround, TheGapIsNeverTooGreatAndTooSmallByLessThanAFifthOfTheShortAxisAcross) {
  const Footprint footprint{FootprintParams{}};
  // Side by side, nose to tail, nose to flank.
  const std::vector<std::pair<Pose2, double>> cases{
      {{0, 0.8, 0}, 0.3}, {{1.5, 0, 0}, 0.4}, {{1.2, 0, std::numbers::pi / 2}, 0.4}, {{3, 0, 0.4}, 1.9}};
  for (const auto& [other, truth] : cases) {
    const double gap = gap_m(footprint, {}, other);
    EXPECT_LE(gap, truth + 0.06);
    EXPECT_GE(gap, truth - 0.06);
  }
  EXPECT_LT(gap_m(footprint, {}, {0.3, 0.2, 0}), 0);
}

}  // namespace
}  // namespace arpent::planning
