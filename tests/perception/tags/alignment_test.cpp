// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/alignment.h"

#include <gtest/gtest.h>

#include <random>

#include "common/error.h"

namespace arpent::tags {
namespace {

Time at(int i) {
  return Time(std::chrono::milliseconds(200 * i + 1000));
}

Pose planar(double x_m, double y_m, double yaw_rad) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(x_m, y_m, 0);
  pose.linear() = so3_exp({0, 0, yaw_rad});
  return pose;
}

/// Poor along the body's y axis and in yaw, as one frontal face gives them.
Matrix6d covariance_of_view() {
  const Vector6d sigma = (Vector6d() << 0.004, 0.012, 0.010, 0.001, 0.004, 0.005).finished();
  Matrix6d C = sigma.cwiseAbs2().asDiagonal();
  C(1, 5) = C(5, 1) = 0.9 * sigma[1] * sigma[5];
  return C;
}

struct Views {
  Pose T_world_odom = planar(1.0, 3.5, 0.4);
  std::mt19937 generator;
  explicit Views(unsigned seed) : generator(seed) {}

  AlignmentView draw(int i) {
    std::normal_distribution<double> normal;
    const Pose T_odom_body = planar(0.05 * i, 0.01 * i, 0.02 * i);
    Vector6d white;
    for (int k = 0; k < 6; ++k) white[k] = normal(generator);
    const Matrix6d C = covariance_of_view();
    const Vector6d error = C.llt().matrixL() * white;
    return make_view(at(i), retract(T_world_odom * T_odom_body, error), C, T_odom_body, Matrix6d::Zero());
  }
};

TEST(TagAlignment, AViewIsMovedToOdomAsDifferencesSay) {
  const Pose T_world_body = retract(planar(1, 2, 0.5), (Vector6d() << 0, 0, 0.1, 0.1, 0.2, 0).finished());
  const Pose T_odom_body = retract(planar(3, -1, 2.0), (Vector6d() << 0, 0, 0.2, -0.1, 0.1, 0).finished());
  for (int k = 0; k < 6; ++k) {
    const double step = 1e-6;
    const Matrix6d C = Vector6d::Unit(k).asDiagonal();
    const AlignmentView view = make_view(at(0), T_world_body, C, T_odom_body, Matrix6d::Zero());
    EXPECT_TRUE(view.T_world_odom.isApprox(T_world_body * T_odom_body.inverse(), 1e-12));
    const Pose moved = retract(T_world_body, step * Vector6d::Unit(k)) * T_odom_body.inverse();
    const Vector6d d = local(view.T_world_odom, moved) / step;
    EXPECT_LT((view.covariance - d * d.transpose()).norm(), 1e-4) << k;
  }
}

TEST(TagAlignment, FiveAgreeingViewsGiveAnAlignmentAndTenABetterOne) {
  Views views(1);
  FrameAligner aligner({}, {});
  std::vector<Alignment> made;
  for (int i = 0; i < 30; ++i) {
    if (const auto alignment = aligner.add(views.draw(i))) made.push_back(*alignment);
    EXPECT_EQ(aligner.is_aligned(), i >= 4);
    EXPECT_EQ(aligner.is_final(), i >= 19);
  }
  ASSERT_EQ(made.size(), 3U);
  EXPECT_EQ(made[0].views, 5);
  EXPECT_EQ(made[1].views, 10);
  EXPECT_EQ(made[2].views, 20);
  EXPECT_EQ(made[0].stamp, at(4));
  EXPECT_LT(made[2].covariance(5, 5), made[0].covariance(5, 5));
  const Vector6d d = local(views.T_world_odom, made[2].T_world_odom);
  EXPECT_LT(d.dot(made[2].covariance.ldlt().solve(d)), 22.46);
}

TEST(TagAlignment, IndependentViewsAreAveragedAsTheirCovarianceSays) {
  double nees = 0;
  constexpr int kTrials = 100;
  for (unsigned seed = 0; seed < kTrials; ++seed) {
    Views views(seed + 1);
    AlignmentParams params;
    params.shared = 0;
    params.max_views = 8;
    FrameAligner aligner(params, {1e6, 1e6});
    std::optional<Alignment> last;
    for (int i = 0; i < 20; ++i) {
      if (const auto alignment = aligner.add(views.draw(i))) last = alignment;
    }
    ASSERT_TRUE(last);
    const Vector6d d = local(views.T_world_odom, last->T_world_odom);
    nees += d.dot(last->covariance.ldlt().solve(d)) / 6 / kTrials;
  }
  EXPECT_NEAR(nees, 1.0, 0.2);  // 600 squares: deviation 0.06
}

TEST(TagAlignment, ViewsThatAgreeWithNobodyAreLeftOut) {
  Views views(2);
  FrameAligner aligner({}, {});
  std::optional<Alignment> made;
  for (int i = 0; i < 12 && !made; ++i) {
    AlignmentView view = views.draw(i);
    if (i % 2 == 1) view.T_world_odom = planar(0.3 * i, 0.2 * i, 0.5 * i) * view.T_world_odom;
    made = aligner.add(view);
    EXPECT_EQ(made.has_value(), i == 8) << i;
  }
  ASSERT_TRUE(made);
  EXPECT_EQ(made->views, 5);
  EXPECT_EQ(aligner.disagreeing(), 3) << "the first wrong one had only one other against it";
  EXPECT_LT(local(views.T_world_odom, made->T_world_odom).head<2>().norm(), 0.03);
}

TEST(TagAlignment, TheGroundMakesOdomsZAxisTheWorlds) {
  Views views(3);
  FrameAligner aligner({}, {0.001, 0.0001});
  std::optional<Alignment> made;
  for (int i = 0; i < 5; ++i) made = aligner.add(views.draw(i));
  ASSERT_TRUE(made);
  EXPECT_LT(std::abs(made->T_world_odom.translation().z()), 0.001);
  EXPECT_LT((made->T_world_odom.linear().col(2) - Eigen::Vector3d::UnitZ()).norm(), 2e-4);
  EXPECT_LT(made->ground_chi2, kGroundGate);
  // A cube that hangs 0.3 m too low contradicts it.
  Views sunk(3);
  sunk.T_world_odom.translation().z() = -0.3;
  FrameAligner other({}, {});
  for (int i = 0; i < 5; ++i) made = other.add(sunk.draw(i));
  ASSERT_TRUE(made);
  EXPECT_GT(made->ground_chi2, kGroundGate);
}

TEST(TagAlignment, IsMadeAnewAfterTheOdometryWasLost) {
  Views views(4);
  FrameAligner aligner({}, {});
  for (int i = 0; i < 5; ++i) (void)aligner.add(views.draw(i));
  ASSERT_TRUE(aligner.is_aligned());
  aligner.forget(at(5));
  EXPECT_FALSE(aligner.is_aligned());
  views.T_world_odom = planar(2.0, 3.0, -0.4);
  EXPECT_FALSE(aligner.add(views.draw(5))) << "it is from before";
  std::optional<Alignment> made;
  for (int i = 6; i <= 10; ++i) made = aligner.add(views.draw(i));
  ASSERT_TRUE(made);
  EXPECT_LT(local(views.T_world_odom, made->T_world_odom).head<2>().norm(), 0.03);
}

TEST(TagAlignment, RefusesParametersThatCannotBe) {
  AlignmentParams params;
  params.max_views = 3;
  EXPECT_THROW(FrameAligner(params, {}), InputError);
  params = {};
  params.shared = 1.5;
  EXPECT_THROW(FrameAligner(params, {}), InputError);
  EXPECT_THROW(FrameAligner({}, {0, 0.01}), InputError);
}

}  // namespace
}  // namespace arpent::tags
