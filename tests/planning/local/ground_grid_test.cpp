// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/ground_grid.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

using mapping::TsdfMap;

GroundGrid grid_of(const TsdfMap& map, const GroundGridParams& params = {}) {
  GroundGrid grid(params);
  grid.update(map);
  return grid;
}

class GroundGridVoxels : public testing::TestWithParam<double> {};

TEST_P(GroundGridVoxels, WallsAndTurnedBoxesStandWhereTheyAre) {
  FlatWorld world;
  world.size_m = {6.03, 5.07};
  world.boxes.push_back({{3.1, 2.4}, {0.6, 0.4}, 0.5});
  const GroundGrid grid = grid_of(make_map(world, GetParam()));
  std::mt19937 random(1);
  int wrong = 0, near = 0;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector2d p(uniform(random, 0.05, 6), uniform(random, 0.05, 5));
    const double d = world.distance_m(p);
    const CellState state = grid.state(p);
    // Corners of boxes are rounded by coarse voxels: there a few centimetres more are allowed.
    if (d > 0.1 + 0.2 * GetParam()) {
      EXPECT_EQ(state, CellState::kFree) << p.transpose();
    }
    if (d < -0.02 && d > -0.5 * GetParam()) {
      wrong += state == CellState::kFree ? 1 : 0;
      ++near;
    }
  }
  EXPECT_LE(wrong, near / 50) << "of " << near << " places just behind a surface";
}

TEST_P(GroundGridVoxels, ARobotHalfAMetreWidePassesAGapOfOneMetreWhereverTheVoxelsLie) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 8; ++trial) {
    const double middle = uniform(random, 2.5, 3.5), x = uniform(random, 2.5, 3.5);
    FlatWorld world;
    world.size_m = {6, 6};
    world.boxes.push_back({{x, middle - 0.5 - 2}, {0.3, 2}});
    world.boxes.push_back({{x, middle + 0.5 + 2}, {0.3, 2}});
    const Ground ground(grid_of(make_map(world, GetParam())), Footprint({}));
    EXPECT_FALSE(ground.first_contact(drive({x - 1.2, middle, 0}, 2.4, 0)));
    EXPECT_GT(ground.margin_m({x, middle, 0}), 0.12) << "of 0.25 m to each side";
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, GroundGridVoxels, testing::Values(0.05, 0.1, 0.2));

TEST(GroundGrid, OnlyTheBandBetweenFloorAndRobotHeightCounts) {
  FlatWorld world;
  world.boxes.push_back({{2, 2}, {0.4, 0.4}, 0, 0.0, 0.3});  // low
  world.boxes.push_back({{4, 2}, {0.4, 0.4}, 0, 0.9, 1.2});  // a table's top
  world.boxes.push_back({{6, 2}, {0.4, 0.4}, 0, 0.3, 1.2});  // a board that hangs low
  const GroundGrid grid = grid_of(make_map(world, 0.1));
  EXPECT_NE(grid.state({2, 2}), CellState::kFree);
  EXPECT_EQ(grid.state({1.65, 2}), CellState::kOccupied);
  EXPECT_EQ(grid.state({4, 2}), CellState::kFree);
  EXPECT_EQ(grid.state({6, 2}), CellState::kOccupied);
  EXPECT_EQ(grid.state({4, 4}), CellState::kFree) << "the floor is no obstacle";
  const GroundGrid taller = grid_of(make_map(world, 0.1), {0.05, 1.0});
  EXPECT_EQ(taller.state({4, 2}), CellState::kOccupied);
  EXPECT_THROW(grid_of(make_map(world, 0.2), {0.05, 0.2}), InputError) << "no voxel's centre in the band";
}

TEST(GroundGrid, OneUnknownVoxelOfTheBandMakesItsColumnUnknown) {
  TsdfMap map = make_map({}, 0.1);
  const mapping::VoxelIndex hole(30, 31, 4);
  const auto forget = [&](const mapping::VoxelIndex& index) {
    map.storage().by_index.at(mapping::block_of(index))->weight[mapping::offset_in_block(index)] = 0.29F;
  };
  forget(hole);
  forget({40, 31, 0});  // under the band
  forget({50, 31, 6});  // above it
  const GroundGrid grid = grid_of(map);
  EXPECT_EQ(grid.state({3.05, 3.15}), CellState::kUnknown);
  EXPECT_EQ(grid.state({3.15, 3.15}), CellState::kFree);
  EXPECT_EQ(grid.state({4.05, 3.15}), CellState::kFree);
  EXPECT_EQ(grid.state({5.05, 3.15}), CellState::kFree);
  EXPECT_EQ(grid.state({-20, 3}), CellState::kUnknown);
}

TEST(GroundGrid, TheDeclaredStartIsFreeUntilDepthSaysOtherwise) {
  GroundGrid grid({});
  grid.declare_free({20, 20}, 0.8);
  EXPECT_EQ(grid.state({20.7, 20}), CellState::kFree);
  EXPECT_EQ(grid.state({20.9, 20}), CellState::kUnknown);
  EXPECT_TRUE(Ground(grid, Footprint({})).is_free({20, 20, 1}));

  FlatWorld world;
  world.boxes.push_back({{4.5, 3}, {0.2, 0.2}});
  GroundGrid start({});
  start.declare_free({4, 3}, 0.8);
  TsdfMap map = make_map(world, 0.1);
  for (auto& block : map.storage().blocks) {  // only a part was seen
    if (block->index.x() < 5) block->weight.fill(0);
  }
  start.update(map);
  EXPECT_EQ(start.state({3.7, 3}), CellState::kFree) << "declared, not seen";
  EXPECT_EQ(start.state({4.5, 3}), CellState::kOccupied) << "declared, but seen to be occupied";
  EXPECT_EQ(start.state({3.0, 3}), CellState::kUnknown);
}

TEST(GroundGrid, WhereARobotStandsIsFreeThoughOthersTookItForSurface) {
  FlatWorld world;
  world.boxes.push_back({{4, 3}, {0.2, 0.15}});  // the robot, as seen before it joined
  world.boxes.push_back({{4, 4}, {0.2, 0.15}});
  const Footprint body({0.3, 0.2});
  GroundGrid grid({});
  grid.declare_free({4, 3}, 0.8);
  grid.update(make_map(world, 0.1));
  EXPECT_FALSE(Ground(grid, body).is_free({4, 3, 0}));
  grid.declare_body(body, {4, 3, 0});
  EXPECT_TRUE(Ground(grid, body).is_free({4, 3, 0}));
  EXPECT_EQ(grid.state({4, 4}), CellState::kOccupied) << "not what stands beside it";
}

TEST(GroundGrid, UpdatesByChangedBlocksEqualAFreshGrid) {
  std::mt19937 random(5);
  const TsdfMap whole = make_map(random_world(random, 6), 0.1);
  TsdfMap map(whole.params());
  GroundGrid grid({});
  grid.declare_free({1, 1}, 0.8);
  std::vector<const mapping::Block*> order;
  for (const auto& block : whole.storage().blocks) order.push_back(block.get());
  std::shuffle(order.begin(), order.end(), random);
  for (std::size_t i = 0; i < order.size(); ++i) {
    auto copy = std::make_unique<mapping::Block>(*order[i]);
    copy->revision = ++map.storage().revision;
    map.storage().adopt(std::move(copy));
    if (i % 7 == 0 || i + 1 == order.size()) grid.update(map);
  }
  EXPECT_EQ(grid.update(map), 0U);
  GroundGrid fresh({});
  fresh.declare_free({1, 1}, 0.8);
  fresh.update(map);
  for (double x = -1; x < 9; x += 0.05) {
    for (double y = -1; y < 8; y += 0.05) {
      ASSERT_EQ(grid.state({x + 0.02, y + 0.02}), fresh.state({x + 0.02, y + 0.02})) << x << ", " << y;
    }
  }
}

TEST(GroundGrid, SaysWhereItChanged) {
  TsdfMap map = make_map({}, 0.1);
  GroundGrid grid({});
  grid.update(map);
  const std::int64_t before = grid.revision();
  mapping::Block& block = *map.storage().by_index.at({5, 5, 0});
  block.distance_m.fill(-0.1F);
  block.revision = ++map.storage().revision;
  EXPECT_GT(grid.update(map), 100U);
  EXPECT_EQ(grid.state({4.4, 4.4}), CellState::kOccupied);
  EXPECT_TRUE(grid.changed_since({{4.2, 4.2}, {4.6, 4.6}}, before));
  EXPECT_FALSE(grid.changed_since({{1, 1}, {2, 2}}, before));
  EXPECT_FALSE(grid.changed_since({{4.2, 4.2}, {4.6, 4.6}}, grid.revision()));
  map.storage().revision = 0;  // another map
  grid.update(TsdfMap(map.params()));
  EXPECT_EQ(grid.state({4.4, 4.4}), CellState::kUnknown);
}

}  // namespace
}  // namespace arpent::planning
