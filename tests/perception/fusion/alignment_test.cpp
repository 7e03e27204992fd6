// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The fused pose in the world: alignments and tags.
#include <gtest/gtest.h>

#include "tests/perception/fusion/drive.h"

namespace arpent::fusion {
namespace {

using std::chrono::milliseconds;

const Pose T_world_odom = Pose2{2, -1, 0.8}.to_pose();

Matrix6d diagonal(double sigma_m, double sigma_rad) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(sigma_m * sigma_m), Eigen::Vector3d::Constant(sigma_rad * sigma_rad);
  return variances.asDiagonal();
}

AlignmentReading alignment(Time stamp, const Pose& T = T_world_odom) {
  return {stamp, T, diagonal(0.01, 0.003)};
}

/// What a tag says at that moment, with an error as its covariance has it.
WorldReading tag(const Drive& drive, Time stamp, std::mt19937& random, double sigma_m = 0.02, double sigma_rad = 0.02) {
  std::normal_distribution<double> normal;
  Vector6d noise;
  for (int k = 0; k < 6; ++k) noise(k) = (k < 3 ? sigma_m : sigma_rad) * normal(random);
  return {stamp, retract(T_world_odom * drive.truth.at(stamp), noise), diagonal(sigma_m, sigma_rad)};
}

Vector6d world_error(const FusedPose& pose, const Drive& drive) {
  return local(pose.T_frame_body, T_world_odom * drive.truth.at(pose.stamp));
}

TEST(PoseFusionAlignment, TheFirstOneMovesThePoseIntoTheWorldFromItsTimeOn) {
  const Drive drive = make_drive({.duration_s = 8});
  PoseFusion fusion({});
  (void)run(fusion, drive);
  const Time stamp = drive.odometry[35].stamp;
  const FusedPose before = *fusion.at(drive.odometry[39].stamp);
  EXPECT_EQ(before.frame, Frame::kOdom);
  EXPECT_EQ(fusion.add(alignment(stamp)), "");
  const FusedPose after = *fusion.at(drive.odometry[39].stamp);
  EXPECT_EQ(after.frame, Frame::kWorld);
  EXPECT_EQ(fusion.at(stamp - milliseconds(1))->frame, Frame::kOdom);
  EXPECT_LT(world_error(after, drive).norm(), 0.08);
  EXPECT_GT(after.covariance.trace(), before.covariance.trace());
  // It counts for the odometry's own frame, whose drift the fused pose does not share in full.
  const Pose T_world_vo = T_world_odom * drive.odometry[35].T_odom_body;
  EXPECT_LT(local(T_world_vo, fusion.at(stamp)->T_frame_body).norm(), 1e-9);
}

TEST(PoseFusionAlignment, OneThatCountsFromLongAgoIsTakenToo) {
  const Drive drive = make_drive({.duration_s = 8});
  PoseFusion fusion({});
  (void)run(fusion, drive);
  EXPECT_EQ(fusion.add(alignment(drive.odometry[2].stamp)), "");
  EXPECT_LT(world_error(*fusion.at(drive.odometry.back().stamp), drive).norm(), 0.08);
}

TEST(PoseFusionAlignment, ALaterOneThatContradictsNeedsASecondThatAgrees) {
  const Drive drive = make_drive({.duration_s = 8});
  PoseFusion fusion({});
  (void)run(fusion, drive);
  EXPECT_EQ(fusion.add(alignment(drive.odometry[30].stamp)), "");
  const Pose wrong = Pose2{3, -1, 0.8}.to_pose(), other = Pose2{2, 3, 0}.to_pose();
  EXPECT_EQ(fusion.add(alignment(drive.odometry[32].stamp, wrong)), "");
  EXPECT_EQ(fusion.add(alignment(drive.odometry[33].stamp, other)), "");
  EXPECT_LT(world_error(*fusion.at(drive.odometry.back().stamp), drive).norm(), 0.08);
  EXPECT_EQ(fusion.newest_state()->refused_alignments, 2);
  EXPECT_EQ(fusion.add(alignment(drive.odometry[35].stamp, other)), "");
  EXPECT_LT(local(other * drive.truth.at(drive.odometry[38].stamp), fusion.at(drive.odometry[38].stamp)->T_frame_body)
                .head<3>()
                .norm(),
            0.2);
}

TEST(PoseFusionTags, TheyHoldTheDriftAndTheCovarianceStaysHonest) {
  constexpr int kSeeds = 20;
  double nees = 0, with_m = 0, without_m = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    DriveParams p = drawn(seed);
    p.duration_s = 80;
    const Drive drive = make_drive(p);
    PoseFusion with({}), without({});
    std::mt19937 random(seed);
    std::vector<Delivery> all = deliveries(drive);
    std::normal_distribution<double> normal;
    // The alignment is itself as wrong as it says.
    Vector6d noise;
    for (int k = 0; k < 6; ++k) noise(k) = (k < 3 ? 0.01 : 0.003) * normal(random);
    const AlignmentReading first = alignment(drive.odometry[5].stamp, retract(T_world_odom, noise));
    all.push_back({first.stamp + milliseconds(200), [first](PoseFusion& f) { return f.add(first); }});
    for (std::size_t i = 50; i < drive.odometry.size(); i += 10) {
      const WorldReading r = tag(drive, drive.odometry[i].stamp, random);
      all.push_back({r.stamp + milliseconds(200), [r, &with](PoseFusion& f) { return &f == &with ? f.add(r) : ""; }});
    }
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
    for (const Delivery& delivery : all) {
      ASSERT_EQ(delivery.add(with), "");
      ASSERT_EQ(delivery.add(without), "");
    }
    const Time end = drive.odometry.back().stamp;
    const FusedPose pose = *with.at(end);
    with_m += world_error(pose, drive).head<2>().norm() / kSeeds;
    without_m += world_error(*without.at(end), drive).head<2>().norm() / kSeeds;
    Eigen::Vector3d e(world_error(pose, drive)(0), world_error(pose, drive)(1), world_error(pose, drive)(5));
    Eigen::Matrix3d P = pose.covariance.topLeftCorner<3, 3>();
    P.row(2) << pose.covariance(5, 0), pose.covariance(5, 1), pose.covariance(5, 5);
    P.col(2) = P.row(2).transpose();
    nees += e.dot(P.llt().solve(e)) / kSeeds;
    EXPECT_GT(with.newest_state()->used_tags, 20);
    EXPECT_EQ(with.newest_state()->refused_tags, 0);
  }
  EXPECT_LT(with_m, 0.5 * without_m);
  EXPECT_LT(nees, 3 + 3 * std::sqrt(6.0 / kSeeds));
  EXPECT_GT(nees, 0.5) << "the tags' floors make it careful, not useless";
}

TEST(PoseFusionTags, AGhostNeverMovesThePoseAndARepeatedLookFromAStandSaysNothingNew) {
  DriveParams p;
  p.duration_s = 10;
  p.profile = [](double) { return Twist2{}; };
  const Drive drive = make_drive(p);
  PoseFusion fusion({});
  std::vector<Delivery> all = deliveries(drive);
  std::mt19937 random(1);
  const AlignmentReading first = alignment(drive.odometry[5].stamp);
  all.push_back({first.stamp + milliseconds(200), [first](PoseFusion& f) { return f.add(first); }});
  for (std::size_t i = 10; i < 50; ++i) {
    WorldReading r = tag(drive, drive.odometry[i].stamp, random);
    if (i % 2 == 0) r.T_world_body = Pose2{7, 3, -2}.to_pose();
    all.push_back({r.stamp + milliseconds(200), [r](PoseFusion& f) { return f.add(r); }});
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
  for (const Delivery& delivery : all) ASSERT_EQ(delivery.add(fusion), "");
  EXPECT_LT(local(T_world_odom, fusion.at(drive.odometry.back().stamp)->T_frame_body).norm(), 0.03);
  EXPECT_EQ(fusion.newest_state()->used_tags, 0);
  // The same ghost after a move is refused by its distance.
  Drive moving = make_drive({.duration_s = 10});
  PoseFusion other({});
  (void)run(other, moving);
  EXPECT_EQ(other.add(alignment(moving.odometry[42].stamp)), "");
  WorldReading ghost = tag(moving, moving.odometry[48].stamp, random);
  ghost.T_world_body = Pose2{7, 3, -2}.to_pose();
  EXPECT_EQ(other.add(ghost), "");
  EXPECT_EQ(other.newest_state()->refused_tags, 1);
  EXPECT_LT(world_error(*other.at(moving.odometry.back().stamp), moving).norm(), 0.05);
}

TEST(PoseFusionTags, TheyAreUsedOnlyInTheWorldAndOnlyIfWanted) {
  const Drive drive = make_drive({.duration_s = 8});
  std::mt19937 random(1);
  FusionParams off;
  off.tags.used = false;
  PoseFusion unaligned({}), unwanted(off);
  (void)run(unaligned, drive);
  (void)run(unwanted, drive);
  EXPECT_EQ(unwanted.add(alignment(drive.odometry[32].stamp)), "");
  for (PoseFusion* fusion : {&unaligned, &unwanted}) {
    const Pose before = fusion->at(drive.odometry.back().stamp)->T_frame_body;
    EXPECT_EQ(fusion->add(tag(drive, drive.odometry[38].stamp, random)), "");
    EXPECT_EQ(fusion->at(drive.odometry.back().stamp)->T_frame_body.matrix(), before.matrix());
  }
}

TEST(PoseFusionTags, ARotationFromATagWeighsLittle) {
  const Drive drive = make_drive({.duration_s = 10});
  PoseFusion fusion({});
  (void)run(fusion, drive);
  EXPECT_EQ(fusion.add(alignment(drive.odometry[42].stamp)), "");
  const Time end = drive.odometry.back().stamp;
  const Pose before = fusion.at(end)->T_frame_body;
  // 3 degrees off, and sure of it.
  WorldReading r{end, retract(before, (Vector6d() << 0, 0, 0, 0, 0, 0.05).finished()), diagonal(0.01, 0.005)};
  EXPECT_EQ(fusion.add(r), "");
  EXPECT_EQ(fusion.newest_state()->used_tags, 1);
  EXPECT_LT(local(before, fusion.at(end)->T_frame_body).tail<3>().norm(), 0.005);
}

}  // namespace
}  // namespace arpent::fusion
