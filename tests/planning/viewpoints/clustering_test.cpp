// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/clustering.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/planning/viewpoints/grid_free_space.h"
#include "tests/planning/viewpoints/scene.h"

namespace arpent::planning {
namespace {

std::vector<Viewpoint> in_a_row(const std::vector<double>& x_m) {
  std::vector<Viewpoint> viewpoints;
  for (const double x : x_m) viewpoints.push_back({{x, 0, 0}, {}, 1});
  return viewpoints;
}

TEST(SingleLinkage, ChainsNearViewpointsAndTakesInLonelyOnes) {
  // 1.5 m apart chain (d_v 2.0); the one at 6.2 is alone, 3.2 m from the next (d_v_max 3.5); the one at 12 stays alone.
  const Partition partition = cluster_by_single_linkage(in_a_row({0, 1.5, 3.0, 6.2, 12}), {});
  EXPECT_EQ(partition, (Partition{{0, 1, 2, 3}, {4}}));
}

TEST(SingleLinkage, DoesNotReachBeyondItsDistancesExactly) {
  EXPECT_EQ(cluster_by_single_linkage(in_a_row({0, 3.5}), {}).size(), 2U) << "d < d_v_max";
  // Two pairs 2.5 m apart: none is alone, so d_v does not grow.
  EXPECT_EQ(cluster_by_single_linkage(in_a_row({0, 0.5, 3.0, 3.5}), {}), (Partition{{0, 1}, {2, 3}}));
}

TEST(DriveClusters, KeepWithinTheirDiameter) {
  const Partition partition = cluster_by_drive(in_a_row({0, 1.5, 3.0, 4.5, 6.0, 7.5}), {}, OpenGround());
  for (const auto& members : partition) EXPECT_LE(members.size(), 3U) << "3 x 1.5 m is more than 4 m";
  EXPECT_LE(partition.size(), 4U);
}

TEST(DriveClusters, AreSeparatedByWallsThatViewsSharePlacesAcross) {
  // A wall at x = 1 with its gap at y > 9: 0.6 m apart, but a long drive.
  const GridFreeSpace ground({-1, -1}, {3, 11}, 0.1,
                             [](const Eigen::Vector2d& p) { return std::abs(p.x() - 1) > 0.15 || p.y() > 9; });
  const auto viewpoints = in_a_row({0.7, 1.3});
  EXPECT_EQ(cluster_by_drive(viewpoints, {}, ground).size(), 2U);
  EXPECT_EQ(cluster_by_single_linkage(viewpoints, {}).size(), 1U) << "Euclidean";
}

TEST(Clusters, HoldEachViewpointExactlyOnceAndTheDiameterAlways) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> at(0, 12);
  const OpenGround ground;
  for (int trial = 0; trial < 30; ++trial) {
    std::vector<Viewpoint> viewpoints;
    for (int i = 0; i < 50; ++i) viewpoints.push_back({{at(random), at(random), 0}, {}, 1});
    for (const bool drive : {true, false}) {
      const Partition partition =
          drive ? cluster_by_drive(viewpoints, {}, ground) : cluster_by_single_linkage(viewpoints, {});
      std::multiset<std::size_t> all;
      for (const auto& members : partition) {
        all.insert(members.begin(), members.end());
        for (const std::size_t a : members) {
          for (const std::size_t b : members) {
            if (!drive) continue;
            EXPECT_LE((viewpoints[a].pose.position_m() - viewpoints[b].pose.position_m()).norm(),
                      ViewpointParams{}.max_diameter_m);
          }
        }
      }
      ASSERT_EQ(all.size(), viewpoints.size());
      EXPECT_EQ(std::set<std::size_t>(all.begin(), all.end()).size(), viewpoints.size());
    }
  }
}

TEST(Gain, IsTheShareOfElementsSeenFromAnyViewpointOfTheCluster) {
  // A wall x > 4 with unknown ends: elements along its border.
  const Eigen::AlignedBox3d box(Eigen::Vector3d(0, -3, 0), Eigen::Vector3d(4.4, 3, 2));
  const auto map =
      make_scene(box, [](const Eigen::Vector3d& p) { return p.x() > 4 ? Content::kOccupied : Content::kEmpty; });
  mapping::IncompleteSurface surface;
  surface.update(map);
  const LevelCamera camera = rig_camera();
  const Sight sight(camera, surface, map);
  ViewpointParams params;
  params.preset = "thesis";
  const std::vector<Viewpoint> viewpoints{{{1.5, 1, 0.3}, {}, 1}, {{1.5, -1, -0.3}, {}, 1}};
  const auto clusters = make_clusters(viewpoints, {{0, 1}}, sight, params);
  std::set<std::uint32_t> seen;
  for (const Viewpoint& viewpoint : viewpoints) {
    const auto from_here = sight.see_elements(viewpoint.pose);
    EXPECT_FALSE(from_here.empty());
    seen.insert(from_here.begin(), from_here.end());
  }
  ASSERT_EQ(clusters.size(), 1U);
  EXPECT_LT(seen.size(), sight.elements().size());
  EXPECT_EQ(clusters[0].elements.size(), seen.size());
  EXPECT_DOUBLE_EQ(clusters[0].gain, static_cast<double>(seen.size()) / static_cast<double>(surface.size()));
  EXPECT_LT((clusters[0].centre_m - Eigen::Vector2d(1.5, 0)).norm(), 1e-12);
}

}  // namespace
}  // namespace arpent::planning
