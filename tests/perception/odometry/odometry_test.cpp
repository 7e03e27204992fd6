// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/odometry/odometry.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "perception/odometry/pose_solver.h"
#include "perception/odometry/window.h"
#include "perception/odometry/wire.h"
#include "sim/sequence.h"
#include "tools/datasets/dataset.h"
#include "tools/evaluation/trajectory.h"

namespace arpent::odometry {
namespace {

const RectifiedStereo kStereo{{320, 256, 188.5, 188.5, 159.5, 127.5}, 0.26};

TEST(OdometryProjection, JacobiansEqualDifferences) {
  const Vector3d p(0.3, -0.2, 2.5);
  const Matrix3d J = project_jacobian(kStereo, p);
  const Pose T = retract(Pose::Identity(), (Vector6d() << 0.1, 0.2, -0.3, 0.05, -0.1, 0.2).finished());
  const Eigen::Matrix<double, 3, 6> J_pose = point_by_pose_jacobian(T.inverse() * p);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 3; ++k) {
    const Vector3d step = kStep * Vector3d::Unit(k);
    EXPECT_TRUE(((project(kStereo, p + step) - project(kStereo, p - step)) / (2 * kStep)).isApprox(J.col(k), 1e-6));
  }
  for (int k = 0; k < 6; ++k) {
    const Vector6d step = kStep * Vector6d::Unit(k);
    const Vector3d difference = (retract(T, step).inverse() * p - retract(T, -step).inverse() * p) / (2 * kStep);
    EXPECT_LT((difference - J_pose.col(k)).norm(), 1e-6) << k;
  }
  EXPECT_TRUE(triangulate(kStereo, project(kStereo, p)).isApprox(p, 1e-12));
}

struct Problem {
  Pose T_truth;
  std::vector<PointMeasurement> measurements;
};

Problem make_problem(unsigned seed, double sigma_px, double outlier_share) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  Problem problem;
  problem.T_truth = retract(Pose::Identity(), (Vector6d() << 0.3, -0.1, 0.4, 0.1, -0.2, 0.05).finished());
  for (int i = 0; i < 150; ++i) {
    const Vector3d p_cam =
        kStereo.camera.unproject(320 * uniform(generator), 256 * uniform(generator), 1 + 9 * uniform(generator));
    PointMeasurement m{problem.T_truth * p_cam, Matrix3d::Zero(), project(kStereo, p_cam), true};
    for (int k = 0; k < 3; ++k) m.z_px[k] += sigma_px * normal(generator);
    if (uniform(generator) < outlier_share)
      m.z_px += Vector3d(60 * uniform(generator) + 8, 40 * uniform(generator) - 20, 0);
    problem.measurements.push_back(m);
  }
  return problem;
}

TEST(OdometryPose, IsFoundAmongFortyPercentOutliers) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Problem problem = make_problem(seed, 0.1, 0.4);
    const auto solution = solve_pose(kStereo, problem.measurements, Pose::Identity(), seed, {});
    EXPECT_LT(local(problem.T_truth, solution.T_odom_cam).norm(), 0.01) << seed;
    EXPECT_GT(solution.inliers, 60);
  }
}

TEST(OdometryPose, ItsCovarianceIsThatOfItsErrors) {
  double sum = 0;
  constexpr int kRuns = 200;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const Problem problem = make_problem(seed, 0.25, 0.0);
    const auto solution = solve_pose(kStereo, problem.measurements, problem.T_truth, seed, {.pixel_sigma_px = 0.25});
    const Vector6d error = local(solution.T_odom_cam, problem.T_truth);
    sum += error.dot(solution.covariance.ldlt().solve(error)) / kRuns;
  }
  EXPECT_GT(sum, 4.0) << "expected 6, the number of parameters";
  EXPECT_LT(sum, 9.0);
}

TEST(OdometryPose, TooFewPointsSaySo) {
  const Problem problem = make_problem(1, 0.1, 0.0);
  const std::vector<PointMeasurement> three(problem.measurements.begin(), problem.measurements.begin() + 3);
  EXPECT_LT(solve_pose(kStereo, three, Pose::Identity(), 1, {}).inliers, 4);
  EXPECT_EQ(solve_pose(kStereo, {}, Pose::Identity(), 1, {}).inliers, 0);
}

/// Four keyframes that see eighty points, with poses and points put wrong. What the cameras measure is short of
/// `offset_px` of disparity.
struct Window {
  std::vector<Pose> truth, poses;
  std::vector<Vector3d> points_truth;
  std::vector<WindowPoint> points;

  explicit Window(double offset_px, double noise_px = 0) {
    std::mt19937 generator(2);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto noise = [&] { return Vector3d(normal(generator), normal(generator), normal(generator)); };
    for (int k = 0; k < 4; ++k) {
      truth.push_back(retract(Pose::Identity(), (Vector6d() << 0.1 * k, 0, 0.2 * k, 0, 0.03 * k, 0).finished()));
      const Vector6d wrong = (Vector6d() << 0.02, -0.01, 0.03, 0.005, 0.004, -0.003).finished();
      poses.push_back(k == 0 ? truth.back() : retract(truth.back(), wrong));
    }
    for (int i = 0; i < 80; ++i) {
      points_truth.push_back(
          kStereo.camera.unproject(320 * uniform(generator), 256 * uniform(generator), 2 + 4 * uniform(generator)));
      WindowPoint point{points_truth.back() + 0.05 * noise(), Matrix3d::Zero(), {}};
      for (int k = 0; k < 4; ++k) {
        const Vector3d seen = project(kStereo, truth[static_cast<std::size_t>(k)].inverse() * points_truth.back());
        point.observations.push_back({k, seen + Vector3d(0, 0, offset_px) + noise_px * noise(), i % 3 != 0 || k == 0});
      }
      points.push_back(point);
    }
  }
};

constexpr double kSurely = 1e-12;  // variance of an offset that is known

TEST(OdometryWindow, RecoversPosesAndPoints) {
  Window w(0);
  DisparityOffset offset{0, kSurely};
  refine_window(kStereo, 0.25, 1, 1, w.poses, w.points, offset);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_LT(local(w.truth[k], w.poses[k]).norm(), 1e-3) << k;
  for (std::size_t i = 0; i < 80; ++i) EXPECT_LT((w.points[i].p_odom_m - w.points_truth[i]).norm(), 0.02);
}

TEST(OdometryWindow, ADisparityOffsetIsToldFromTrueDepth) {
  for (const double truth_px : {0.0, 0.3, -0.2}) {
    Window w(truth_px);
    DisparityOffset offset{0, 100};
    refine_window(kStereo, 0.25, 1, 1, w.poses, w.points, offset);
    EXPECT_NEAR(offset.px, truth_px, 0.02);
    EXPECT_NEAR((w.poses[3].translation() - w.poses[0].translation()).norm(), w.truth[3].translation().norm(), 0.003);
    EXPECT_LT(offset.variance_px2, 1);
  }
}

TEST(OdometryWindow, WhatIsBelievedOfTheOffsetWeighsAgainstTheImages) {
  Window w(0.3, 0.25);
  DisparityOffset sure{0, kSurely}, unsure{0, 0.01};
  auto poses = w.poses;
  auto points = w.points;
  refine_window(kStereo, 0.25, 1, 1, poses, points, sure);
  EXPECT_NEAR(sure.px, 0, 1e-6);
  const double before = unsure.variance_px2;
  refine_window(kStereo, 0.25, 1, 0.5, w.poses, w.points, unsure);
  EXPECT_GT(unsure.px, 0);
  EXPECT_LT(unsure.px, 0.35);
  EXPECT_LT(unsure.variance_px2, before);
}

/// The rendered drive, in the left camera's own first frame.
class OdometryDrive : public testing::Test {
 protected:
  sim::Scene scene_ = sim::make_test_arena();
  Pose T_body_cam_ = [] {
    Pose T(R_body_from_camera_axes());
    T.translation() = Eigen::Vector3d(0.2, 0.13, 0.4);
    return T;
  }();
  std::vector<sim::DrivePose> drive_ = sim::make_arena_drive(3.0, 5, Time());

  sim::RenderedPair pair(const sim::DrivePose& pose, std::uint64_t number) const {
    return sim::render_pair(scene_, kStereo, T_body_cam_, pose, number);
  }
  Pose truth(const sim::DrivePose& pose) const {
    return (drive_[0].T_world_body * T_body_cam_).inverse() * pose.T_world_body * T_body_cam_;
  }
};

TEST_F(OdometryDrive, FollowsADriveAndGivesTheSameNumbersTwice) {
  StereoOdometry first(kStereo, {}), second(kStereo, {});
  for (std::size_t i = 0; i < drive_.size(); ++i) {
    const auto p = pair(drive_[i], i);
    const Estimate a = first.track(drive_[i].stamp, p.left, p.right),
                   b = second.track(drive_[i].stamp, p.left, p.right);
    EXPECT_NE(a.status, Status::kLost) << i << a.reason;
    EXPECT_EQ(a.T_odom_cam.matrix(), b.T_odom_cam.matrix());
    EXPECT_LT((a.T_odom_cam.translation() - truth(drive_[i]).translation()).norm(), 0.05) << i;
    EXPECT_LT(so3_log(a.T_odom_cam.linear().transpose() * truth(drive_[i]).linear()).norm(), 0.01) << i;
  }
}

TEST_F(OdometryDrive, AScaleThatASlightlyTurnedCameraWouldFalsifyIsKept) {
  // The right camera's principal point is a third of a pixel off: points at 4 m appear 3 % too far away.
  PinholeCamera off = kStereo.camera;
  off.cx_px += 0.33;
  const auto drive = sim::make_arena_drive(6.0, 5, Time());
  StereoOdometry odometry(kStereo, {});
  double estimated_m = 0, true_m = 0;
  Vector3d last = Vector3d::Zero(), last_truth = Vector3d::Zero();
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const Pose T_world_left = drive[i].T_world_body * T_body_cam_;
    const auto left = sim::render(scene_, kStereo.camera, T_world_left, {}, 2 * i);
    const auto right = sim::render(scene_, off, T_world_left * Eigen::Translation3d(0.26, 0, 0), {}, 2 * i + 1);
    const Vector3d now = odometry.track(drive[i].stamp, left.image, right.image).T_odom_cam.translation();
    const Vector3d now_truth = truth(drive[i]).translation();
    estimated_m += (now - last).norm();
    true_m += (now_truth - last_truth).norm();
    last = now;
    last_truth = now_truth;
  }
  EXPECT_NEAR(estimated_m / true_m, 1, 0.012);
  // u_right appears too far right: disparities are short.
  EXPECT_NEAR(odometry.disparity_offset().px, 0.33, 0.15);
}

TEST_F(OdometryDrive, AtRestItStaysAndACreepIsFollowed) {
  StereoOdometry odometry(kStereo, {});
  Estimate estimate;
  for (std::uint64_t i = 0; i < 15; ++i) {
    const auto p = pair(drive_[0], i);
    estimate = odometry.track(Time(), p.left, p.right);
  }
  EXPECT_LT(estimate.T_odom_cam.translation().norm(), 0.005);
  sim::DrivePose creeping = drive_[0];
  for (std::uint64_t i = 0; i < 30; ++i) {
    creeping.T_world_body = creeping.T_world_body * Eigen::Translation3d(0.002, 0, 0);
    const auto p = pair(creeping, 100 + i);
    estimate = odometry.track(Time(), p.left, p.right);
  }
  EXPECT_LT((estimate.T_odom_cam.translation() - truth(creeping).translation()).norm(), 0.006);
}

TEST_F(OdometryDrive, ABlindMomentIsLostAndTheWayGoesOnWithoutAJump) {
  StereoOdometry odometry(kStereo, {});
  Estimate before, blind;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto p = pair(drive_[i], i);
    before = odometry.track(drive_[i].stamp, p.left, p.right);
  }
  blind = odometry.track(drive_[4].stamp, cv::Mat1b(256, 320, std::uint8_t{0}), cv::Mat1b(256, 320, std::uint8_t{0}));
  EXPECT_EQ(blind.status, Status::kLost);
  EXPECT_FALSE(blind.reason.empty());
  EXPECT_EQ(blind.T_odom_cam.matrix(), before.T_odom_cam.matrix());
  Estimate after;
  for (std::size_t i = 5; i < 8; ++i) {
    const auto p = pair(drive_[i], i);
    after = odometry.track(drive_[i].stamp, p.left, p.right);
  }
  EXPECT_EQ(after.status, Status::kOk);
  const double moved = (truth(drive_[7]).translation() - truth(drive_[5]).translation()).norm();
  EXPECT_NEAR((after.T_odom_cam.translation() - before.T_odom_cam.translation()).norm(), moved, 0.02);
  EXPECT_GT(after.covariance.trace(), before.covariance.trace() + 1) << "the gap is uncertain";
}

TEST_F(OdometryDrive, AnAutomaticExposureDoesNotMoveFaintTexture) {
  // A quarter of the contrast, and from pair to pair brighter or darker by a sixth, as when a robot turns to a window.
  StereoOdometry odometry(kStereo, {});
  for (std::size_t i = 0; i < drive_.size(); ++i) {
    auto p = pair(drive_[i], i);
    const double exposure = i % 2 == 0 ? 1.0 : 1.0 / 6 + 1;
    for (cv::Mat1b* image : {&p.left, &p.right}) image->convertTo(*image, CV_8U, 0.25 * exposure, 80 * exposure);
    const Estimate e = odometry.track(drive_[i].stamp, p.left, p.right);
    EXPECT_NE(e.status, Status::kLost) << i << e.reason;
    EXPECT_LT((e.T_odom_cam.translation() - truth(drive_[i]).translation()).norm(), 0.05) << i;
    EXPECT_LT(so3_log(e.T_odom_cam.linear().transpose() * truth(drive_[i]).linear()).norm(), 0.01) << i;
  }
}

TEST_F(OdometryDrive, AGyroFindsPointsThatATurnMovedFar) {
  // Turning on the spot by 15 degrees from pair to pair: a quarter of the image.
  constexpr double kTurnRad = 0.26;
  int found_with = 0, found_without = 0;
  StereoOdometry with(kStereo, {}), without(kStereo, {});
  sim::DrivePose turning = drive_[0];
  const Eigen::Matrix3d R_body = Eigen::AngleAxisd(kTurnRad, Vector3d::UnitZ()).toRotationMatrix();
  Pose T_body_step = Pose::Identity();
  T_body_step.linear() = R_body;
  const Pose turn = T_body_cam_.inverse() * T_body_step * T_body_cam_;
  for (std::uint64_t i = 0; i < 12; ++i) {
    const bool turns = i % 3 == 2;  // suddenly, so that no constant motion predicts it
    if (turns) turning.T_world_body.linear() = turning.T_world_body.linear() * R_body;
    const auto p = pair(turning, i);
    const Pose hint = turns ? turn : Pose::Identity();
    const Estimate a = with.track(Time(), p.left, p.right, hint), b = without.track(Time(), p.left, p.right);
    found_with += a.status != Status::kLost ? 1 : 0;
    found_without += b.status != Status::kLost ? 1 : 0;
    EXPECT_LT(so3_log(a.T_odom_cam.linear().transpose() * truth(turning).linear()).norm(), 0.01) << i;
  }
  EXPECT_EQ(found_with, 12);
  EXPECT_LE(found_without, found_with);
}

TEST(Odometry, ImagesOfAnotherSizeAreLostWithAReason) {
  StereoOdometry odometry(kStereo, {});
  const Estimate estimate =
      odometry.track(Time(), cv::Mat1b(10, 10, std::uint8_t{1}), cv::Mat1b(10, 10, std::uint8_t{1}));
  EXPECT_EQ(estimate.status, Status::kLost);
  EXPECT_FALSE(estimate.reason.empty());
}

TEST(Odometry, TheRealClipIsFollowed) {
  const char* data = std::getenv("ARPENT_DATA");
  if (data == nullptr) GTEST_SKIP() << "ARPENT_DATA is not set";
  const tools::Dataset set = tools::read_kitti(std::string(data) + "/vo/kitti06_0000-0039");
  StereoOdometry odometry({set.calibration.left.pinhole, -set.calibration.T_right_left.translation().x()}, {});
  evaluation::Trajectory reference, estimate;
  const Pose T_bc = set.calibration.T_body_left;
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    const auto e = odometry.track(set.frames[i].stamp, cv::imread(set.frames[i].left.string(), cv::IMREAD_GRAYSCALE),
                                  cv::imread(set.frames[i].right.string(), cv::IMREAD_GRAYSCALE));
    estimate.push_back({e.stamp, e.T_odom_cam});
    reference.push_back({e.stamp, T_bc.inverse() * set.truth[i].T_world_body * T_bc});
  }
  const auto errors = evaluation::evaluate(reference, estimate, evaluation::Alignment::kSe3);
  EXPECT_LT(errors.ate_m.rmse, 0.08);
  EXPECT_LT(errors.segments.t_rel_percent, 0.85);
}

TEST(OdometryWire, EveryFieldSurvivesAndImpossibleOnesAreRefused) {
  BodyOdometry odometry;
  odometry.stamp = from_utime(1);
  odometry.sequence = 2;
  odometry.T_odom_body = retract(Pose::Identity(), (Vector6d() << 1, 2, 3, 0.1, 0.2, 0.3).finished());
  odometry.velocity_body << 4, 5, 6, 7, 8, 9;
  for (int i = 0; i < 36; ++i)
    odometry.covariance(i / 6, i % 6) = 10 + i, odometry.step_covariance(i / 6, i % 6) = 50 + i;
  odometry.status = Status::kDegraded;
  odometry.reason = "few points";
  odometry.tracked = 11;
  odometry.inliers = 12;
  odometry.keyframe = true;
  const odometry_t message = to_wire(odometry);
  const auto back = from_wire(message);
  ASSERT_TRUE(back) << back.fault();
  EXPECT_EQ(back->stamp, odometry.stamp);
  EXPECT_EQ(back->sequence, 2);
  EXPECT_TRUE(back->T_odom_body.isApprox(odometry.T_odom_body, 1e-12));
  EXPECT_EQ(back->velocity_body, odometry.velocity_body);
  EXPECT_EQ(back->covariance, odometry.covariance);
  EXPECT_EQ(back->step_covariance, odometry.step_covariance);
  EXPECT_EQ(back->status, Status::kDegraded);
  EXPECT_EQ(back->reason, "few points");
  EXPECT_EQ(back->tracked, 11);
  EXPECT_EQ(back->inliers, 12);
  EXPECT_TRUE(back->keyframe);
  const auto refused = [&](auto damage) {
    odometry_t bad = message;
    damage(bad);
    return !from_wire(bad);
  };
  EXPECT_TRUE(refused([](auto& m) { m.status = 3; }));
  EXPECT_TRUE(refused([](auto& m) { m.position_m[1] = std::nan(""); }));
  EXPECT_TRUE(refused([](auto& m) { m.orientation_wxyz[0] = 3; }));
  EXPECT_TRUE(refused([](auto& m) { m.velocity_mps[2] = std::nan(""); }));
  EXPECT_TRUE(refused([](auto& m) { m.covariance[3][3] = -1; }));
  EXPECT_TRUE(refused([](auto& m) { m.child_frame = "nose"; }));
}

}  // namespace
}  // namespace arpent::odometry
