// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/certificate/check.h"

#include <gtest/gtest.h>

#include "tests/tools/evaluation/small_worlds.h"

namespace arpent::tools {
namespace {

using Eigen::Vector3d;
using evaluation::small_robot;
using planning::CertifiedElement;
using planning::Verdict;

/// A room with a box, and in a corner a hollow between walls that nobody can look into. The mesh lacks the floor beyond
/// x = 2.5, so that something is missing nearly everywhere there.
class CertificateCheckTest : public testing::Test {
 protected:
  CertificateCheckTest()
      : world_(evaluation::room_with(R"(  - box: {centre_m: [3, 1, 0.5], size_m: [0.8, 0.8, 1.0], texture: plain}
  - box: {centre_m: [4.2, 3.5, 0.75], size_m: [0.1, 1.0, 1.5], texture: plain}
  - box: {centre_m: [4.6, 3.05, 0.75], size_m: [0.9, 0.1, 1.5], texture: plain}
)")),
        views_(world_, world_.starts.front(), small_robot()),
        truth_(evaluation::find_true_surface(world_, views_)) {
    TriangleMesh mesh;
    mesh.vertices_m = {{0, 0, 0}, {2.5F, 0, 0}, {2.5F, 4, 0}, {0, 4, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    reconstruction_ = evaluation::evaluate_reconstruction(truth_, mesh, 0.1);
    file_.context.camera = small_robot().camera;
  }

  CheckedElement judge(Verdict verdict, const Vector3d& place_m, const Looks& looks = {}) {
    file_.elements = {{.verdict = verdict, .place_m = place_m}};
    return check_certificates(file_, {views_, truth_, reconstruction_, looks}).elements.front();
  }

  sim::World world_;
  evaluation::LegalViews views_;
  evaluation::TrueSurface truth_;
  evaluation::Reconstruction reconstruction_;
  planning::CertificateFile file_;
};

TEST_F(CertificateCheckTest, WhatNobodyCanSeeIsRightlyLeft) {
  EXPECT_EQ(judge(Verdict::kUnreachable, {4.6, 3.6, 0.1}).finding, Finding::kTrue) << "in the hollow";
  EXPECT_EQ(judge(Verdict::kOccluded, {3, 1, 0.5}).finding, Finding::kTrue) << "inside the box";
}

TEST_F(CertificateCheckTest, AnExcuseForMissingSurfaceThatCouldBeSeenIsFalse) {
  for (const Verdict verdict : {Verdict::kUnreachable, Verdict::kOccluded, Verdict::kOutOfRange,
                                Verdict::kBelowSensingLimit, Verdict::kCompletable}) {
    const CheckedElement checked = judge(verdict, {3.5, 2.5, 0.05});
    EXPECT_EQ(checked.finding, Finding::kFalse) << to_text(verdict);
    EXPECT_FALSE(checked.remark.empty());
  }
}

TEST_F(CertificateCheckTest, AFalseExcuseWhereNothingIsMissingIsMoot) {
  EXPECT_EQ(judge(Verdict::kUnreachable, {1.5, 2.5, 0.05}).finding, Finding::kMoot);
}

TEST_F(CertificateCheckTest, OutOfRangeIsAQuestionOfHeight) {
  // Slopes of 0.68: at 5 m the view ends 3.4 m above the camera, which is 0.40 m above ground.
  EXPECT_EQ(judge(Verdict::kOutOfRange, {3.5, 2.5, 3.85}).finding, Finding::kTrue);
  EXPECT_EQ(judge(Verdict::kOutOfRange, {3.5, 2.5, 0.1}).finding, Finding::kFalse);
}

TEST_F(CertificateCheckTest, TheSensingLimitIsReachedByLooksThatAreWorthEnough) {
  // A look from 2 m is worth 1/4; 4 times W_th = 0.3 are 1.2: five looks.
  const Vector3d place(3.7, 2.5, 0.05);
  const Pose2 body{3.7 - 2 - 0.20, 2.5 - 0.13, 0};
  EXPECT_EQ(judge(Verdict::kBelowSensingLimit, place, Looks(5, body)).finding, Finding::kTrue);
  EXPECT_EQ(judge(Verdict::kBelowSensingLimit, place, Looks(4, body)).finding, Finding::kFalse);
  EXPECT_EQ(judge(Verdict::kBelowSensingLimit, place, Looks(50, {body.x_m, body.y_m, 3.1})).finding, Finding::kFalse)
      << "looking away";
}

TEST_F(CertificateCheckTest, ASmallPieceIsAsSmallAsItsElementsTogether) {
  file_.context.least_piece_m = 0.25;
  const auto element = [](int x) {
    return CertifiedElement{.voxel = {x, 25, 0},
                            .verdict = Verdict::kBelowSensingLimit,
                            .place_m = {0.1 * x + 0.05, 2.55, 0.05},
                            .small_piece = true};
  };
  file_.elements = {element(33), element(34), element(37)};
  const CertificateCheck two = check_certificates(file_, {views_, truth_, reconstruction_, {}});
  EXPECT_EQ(two.true_count, 3);
  EXPECT_EQ(two.small_pieces, 3);
  file_.elements = {element(33), element(34), element(35), element(37)};
  const CertificateCheck three = check_certificates(file_, {views_, truth_, reconstruction_, {}});
  EXPECT_EQ(three.elements.front().finding, Finding::kFalse) << "0.3 m";
  EXPECT_EQ(three.elements.back().finding, Finding::kTrue);
  file_.elements[1].small_piece = false;
  file_.elements[1].verdict = Verdict::kOutOfRange;
  EXPECT_EQ(check_certificates(file_, {views_, truth_, reconstruction_, {}}).elements.front().finding, Finding::kTrue)
      << "what has a reason of its own does not count";
}

TEST_F(CertificateCheckTest, SharesAreOfAllElements) {
  file_.elements = {{.verdict = Verdict::kUnreachable, .place_m = {4.6, 3.6, 0.1}},
                    {.verdict = Verdict::kUnreachable, .place_m = {3.5, 2.5, 0.05}},
                    {.verdict = Verdict::kUnreachable, .place_m = {1.5, 2.5, 0.05}},
                    {.verdict = Verdict::kCompletable, .place_m = {3.5, 2.5, 0.05}}};
  const CertificateCheck check = check_certificates(file_, {views_, truth_, reconstruction_, {}});
  EXPECT_EQ(check.valid_percent(), 50);
  EXPECT_EQ(check.true_percent(), 25);
  EXPECT_EQ(check.unfinished, 1);
  EXPECT_GT(check.uncovered_m2, 8) << "the floor beyond x = 2.5 m, and all walls";
  EXPECT_EQ(check_certificates({}, {views_, truth_, reconstruction_, {}}).valid_percent(), 100);
}

}  // namespace
}  // namespace arpent::tools
