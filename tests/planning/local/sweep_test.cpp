// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/sweep.h"

#include <gtest/gtest.h>

#include <queue>

#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

/// Dijkstra's algorithm as in the book, on the same graph.
std::vector<std::uint32_t> plain_dijkstra(const Ground& ground, std::size_t source) {
  const GridFrame& frame = ground.frame();
  const auto& weights = ground.weights();
  std::vector<std::uint32_t> costs(frame.size(), Sweep::kNotReached);
  using Entry = std::pair<std::uint32_t, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  costs[source] = 0;
  open.emplace(0, source);
  while (!open.empty()) {
    const auto [cost, at] = open.top();
    open.pop();
    if (cost != costs[at]) continue;
    const int i = static_cast<int>(at % static_cast<std::size_t>(frame.cols));
    const int j = static_cast<int>(at / static_cast<std::size_t>(frame.cols));
    for (const GridStep& step : grid_steps()) {
      const auto weight = [&](int x, int y) -> std::uint32_t { return frame.has(x, y) ? weights[frame.at(x, y)] : 0; };
      const std::uint32_t there = weight(i + step.dx, j + step.dy);
      if (there == 0) continue;
      if (std::abs(step.dx * step.dy) == 2) {  // a knight's move crosses two cells
        const int sx = step.dx > 0 ? 1 : -1, sy = step.dy > 0 ? 1 : -1;
        const bool flat = std::abs(step.dx) == 2;
        if (weight(i + (flat ? sx : 0), j + (flat ? 0 : sy)) == 0 || weight(i + sx, j + sy) == 0) continue;
      }
      const std::uint32_t next = cost + (static_cast<std::uint32_t>(step.length) * (weight(i, j) + there)) / 128;
      const std::size_t to = frame.at(i + step.dx, j + step.dy);
      if (next >= costs[to]) continue;
      costs[to] = next;
      open.emplace(next, to);
    }
  }
  return costs;
}

TEST(Sweep, CostsEqualPlainDijkstra) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 10; ++trial) {
    const FlatWorld world = random_world(random, 8);
    const Ground ground = make_ground(world);
    Eigen::Vector2i cell;
    Eigen::Vector2d source;
    do {
      source = {uniform(random, 0.5, 7.5), uniform(random, 0.5, 6.5)};
      cell = ground.frame().cell_of(source);
    } while (ground.weights()[ground.frame().at(cell.x(), cell.y())] == 0);
    const Sweep sweep(ground, source);
    EXPECT_EQ(sweep.costs(), plain_dijkstra(ground, ground.frame().at(cell.x(), cell.y())));
  }
}

TEST(Sweep, LengthsInTheOpenAreStraightToWithinThreePercent) {
  const Ground ground = make_ground({{20, 20}, {}});
  const Eigen::Vector2d from(10, 10);
  const Sweep sweep(ground, from);
  for (int i = 0; i < 64; ++i) {
    const Eigen::Vector2d to = from + 7 * Eigen::Vector2d(std::cos(0.1 * i), std::sin(0.1 * i));
    const auto length = sweep.length_m(to);
    ASSERT_TRUE(length);
    EXPECT_GE(*length, 7 - 1e-9);
    EXPECT_LE(*length, 7 * 1.028 + 0.05);
    EXPECT_NEAR(*sweep.cost_m(to), *length, 0.06) << "nothing is near";
  }
}

TEST(Sweep, EndingEarlyChangesNothingOfWhatWasReached) {
  std::mt19937 random(4);
  const FlatWorld world = random_world(random, 5);
  const Ground ground = make_ground(world);
  const Eigen::Vector2d from(0.6, 0.6), to(4.0, 0.6);
  const Sweep full(ground, from), early(ground, from, 1e9, to, 0.5), near(ground, from, 2.0);
  ASSERT_TRUE(full.cost_m(to));
  EXPECT_EQ(full.cost_m(to), early.cost_m(to));
  std::size_t reached = 0;
  for (std::size_t at = 0; at < full.costs().size(); ++at) {
    if (early.costs()[at] != Sweep::kNotReached) ++reached;
    const double cost_m = full.costs()[at] / 1024.0 * 0.05;
    if (cost_m < *full.cost_m(to) + 0.5 - 0.01) {
      EXPECT_EQ(early.costs()[at], full.costs()[at]);
    }
    if (cost_m < 1.99) {
      EXPECT_EQ(near.costs()[at], full.costs()[at]);
    }
    if (cost_m > 2.01) {
      EXPECT_EQ(near.costs()[at], Sweep::kNotReached);
    }
  }
  EXPECT_LT(reached, full.costs().size() / 2);
}

TEST(Sweep, DriveLengthsAnswerForFreeSpace) {
  std::mt19937 random(6);
  const Ground ground = make_ground(random_world(random, 6));
  std::vector<Pose2> poses;
  while (poses.size() < 40) {
    const Pose2 pose{uniform(random, 0, 8), uniform(random, 0, 7), 0};
    if (ground.is_free(pose)) poses.push_back(pose);
  }
  const auto all = drive_lengths_m(ground, poses.front(), poses);
  const auto near = drive_lengths_m(ground, poses.front(), poses, 3.0);
  EXPECT_NEAR(all.front().value(), 0, 1e-9);
  int within = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    within += near[i] ? 1 : 0;
    EXPECT_EQ(near[i], all[i] && *all[i] <= 3 ? all[i] : std::nullopt);
  }
  EXPECT_GT(within, 5);
  EXPECT_LT(within, 35);
}

TEST(Sweep, AClosedRoomIsNotReachedAndAWayIsConnected) {
  FlatWorld world;
  world.boxes.push_back({{4, 3.5}, {0.1, 3.5}});
  const Ground ground = make_ground(world);
  const Sweep sweep(ground, {1, 1});
  EXPECT_FALSE(sweep.cost_m({6, 3}));
  EXPECT_TRUE(sweep.way_to({6, 3}).empty());
  const auto way = sweep.way_to({1, 6});
  ASSERT_GT(way.size(), 2U);
  EXPECT_LT((way.front() - Eigen::Vector2d(1, 1)).norm(), 0.05);
  EXPECT_LT((way.back() - Eigen::Vector2d(1, 6)).norm(), 0.05);
  for (std::size_t i = 1; i < way.size(); ++i) EXPECT_LT((way[i] - way[i - 1]).norm(), 0.12);
  EXPECT_FALSE(Sweep(ground, {4, 3}).cost_m({1, 1})) << "from within the wall";
}

}  // namespace
}  // namespace arpent::planning
