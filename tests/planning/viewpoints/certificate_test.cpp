// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Why an element stays incomplete, in rooms made by hand. The element is a hole in the wall x = 6 (or what the test
// says); the rest is known, and only that element is judged.
#include "planning/viewpoints/certificate.h"

#include <gtest/gtest.h>

#include "tests/planning/viewpoints/grid_free_space.h"
#include "tests/planning/viewpoints/scene.h"

namespace arpent::planning {
namespace {

struct Room {
  Eigen::Vector3d hole_m{6.1, 0.1, 0.5};                 ///< unknown voxel in the wall, right behind the element
  Eigen::AlignedBox3d obstacle = Eigen::AlignedBox3d();  ///< occupied, if not empty
  double height_m = 2.4;
  double free_until_m = 5.4;  ///< where the robot may stand
  double start_m = 0;
  VoxelSet given_up;
};

Certificate judge(const Room& room) {
  const Eigen::AlignedBox3d known(Eigen::Vector3d(-1, -3, -0.4), Eigen::Vector3d(6.6, 3, room.height_m));
  const auto map = make_scene(known, [&](const Eigen::Vector3d& p) {
    if ((p - room.hole_m).cwiseAbs().maxCoeff() < 0.05) return Content::kUnknown;
    return p.x() > 6 || p.z() < 0 || room.obstacle.contains(p) ? Content::kOccupied : Content::kEmpty;
  });
  mapping::IncompleteSurface surface;
  surface.update(map);
  const LevelCamera camera = rig_camera();
  const Sight sight(camera, surface, map, room.given_up);
  const GridFreeSpace ground({-1, -3}, {7, 3}, 0.1, [&](const Eigen::Vector2d& p) {
    return p.x() < room.free_until_m && !room.obstacle.contains(Eigen::Vector3d(p.x(), p.y(), 0.5));
  });
  const ViewpointParams params;
  const Certifier certifier(sight, ground, {room.start_m, 0, 0}, params);
  const VoxelIndex wanted = map.index_of(room.hole_m) - VoxelIndex(1, 0, 0);
  for (std::size_t i = 0; i < sight.elements().size(); ++i) {
    if (sight.elements()[i].voxel == wanted) return certifier.judge(i);
  }
  ADD_FAILURE() << "the hole makes no element";
  return {};
}

TEST(Certificate, AHoleInAnOpenWallIsCompletable) {
  const Certificate certificate = judge({});
  EXPECT_EQ(certificate.verdict, Verdict::kCompletable);
  ASSERT_EQ(certificate.poses.size(), 1U);
  EXPECT_TRUE(CameraView(rig_camera(), certificate.poses[0]).contains({6.1, 0.1, 0.5}));
}

TEST(Certificate, WhatAScreenHidesFromEveryPoseIsOccluded) {
  Room room;
  room.obstacle = {Eigen::Vector3d(5, -3, 0), Eigen::Vector3d(5.4, 3, 2.4)};
  room.free_until_m = 4.6;
  const Certificate certificate = judge(room);
  EXPECT_EQ(certificate.verdict, Verdict::kOccluded);
  EXPECT_GT(certificate.in_view, 100);
  EXPECT_EQ(certificate.in_sight, 0);
  EXPECT_LT((certificate.unknown_m - room.hole_m).norm(), 1e-9);
}

TEST(Certificate, ABoxThatHidesFromSomePosesOnlyIsNoExcuse) {
  Room room;
  room.obstacle = {Eigen::Vector3d(4, -1, 0), Eigen::Vector3d(5, 1, 2.4)};
  EXPECT_EQ(judge(room).verdict, Verdict::kCompletable);
}

TEST(Certificate, AClosedCavityIsOccluded) {
  // The hole lies at the far end of a pocket in a thick wall whose mouth is closed.
  Room room;
  room.obstacle = {Eigen::Vector3d(5.4, -3, 0), Eigen::Vector3d(5.8, 3, 2.4)};
  room.free_until_m = 5.2;
  EXPECT_EQ(judge(room).verdict, Verdict::kOccluded);
}

TEST(Certificate, AWallAboveTheViewIsOutOfRange) {
  // In view from 5 m up to 0.4 + 5 * 256 / 377 = 3.80 m.
  Room room;
  room.height_m = 4.4;
  room.hole_m = {6.1, 0.1, 4.1};
  EXPECT_EQ(judge(room).verdict, Verdict::kOutOfRange);
  room.hole_m.z() = 3.3;
  EXPECT_EQ(judge(room).verdict, Verdict::kCompletable);
}

TEST(Certificate, WhereTheRobotCannotStandItIsUnreachable) {
  Room room;
  // The frustum's far corner is 5 m * hypot(1, 320 / 377) = 6.56 m away, the hole at least 6.1 + 0.75 - 0.2 = 6.65 m.
  room.free_until_m = -0.75;
  room.start_m = -0.9;
  const Certificate certificate = judge(room);
  EXPECT_EQ(certificate.verdict, Verdict::kUnreachable);
  EXPECT_EQ(certificate.in_view, 0);
}

TEST(Certificate, WhatLooksDidNotMakeKnownIsBelowTheSensingLimit) {
  Room room;
  room.given_up.insert((room.hole_m / 0.2).array().floor().cast<int>());
  const Certificate certificate = judge(room);
  EXPECT_EQ(certificate.verdict, Verdict::kBelowSensingLimit);
  EXPECT_GT(certificate.in_sight, 0);
  EXPECT_STREQ(to_text(certificate.verdict), "below_sensing_limit");
}

}  // namespace
}  // namespace arpent::planning
