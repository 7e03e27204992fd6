// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/detect.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

#include "calib/lens.h"
#include "perception/tags/detector.h"
#include "tests/calib/board_picture.h"
#include "tests/calib/simulated_views.h"

namespace arpent::calib {
namespace {

/// A board held before the left camera of the simulated rig, turned and tilted.
Pose held_board(const Target& target, double z_m) {
  Pose T = Pose::Identity();
  T.linear() = so3_exp({0.3, -0.25, 0.2}) * so3_exp({M_PI, 0, 0});
  const Eigen::Vector2d middle_m = 0.5 * target.size_m();
  T.translation() = Eigen::Vector3d(0, 0, z_m) - T.linear() * Eigen::Vector3d(middle_m.x(), middle_m.y(), 0);
  return T;
}

struct Errors {
  std::size_t found = 0;
  double rms_px = 0;
};

Errors detect_and_compare(const Target& target) {
  const RigEstimate rig = simulated_rig(DistortionModel::kRadialTangential);
  const sim::CameraModel camera(rig.cameras[0]);
  const Pose T_cam_board = held_board(target, 0.8);
  const Corners corners = BoardDetector(target).detect(draw_board(target, camera, T_cam_board, 3));
  Errors errors{corners.size(), 0};
  for (const Corner& corner : corners) {
    const Eigen::Vector2d b = target.corner_m(corner.index);
    const Eigen::Vector3d p = T_cam_board * Eigen::Vector3d(b.x(), b.y(), 0);
    const LensParameters lens = to_parameters(rig.cameras[0]);
    Eigen::Vector2d px;
    project(rig.cameras[0].distortion, lens.data(), p.data(), px.data());
    errors.rms_px += (px - corner.px).squaredNorm() / static_cast<double>(corners.size());
  }
  errors.rms_px = std::sqrt(errors.rms_px);
  return errors;
}

TEST(BoardDetector, FindsEveryCornerOfKalibrsGridWithTwoBlackCellsAround) {
  const Errors errors = detect_and_compare(Target{});
  EXPECT_EQ(errors.found, 144U);
  EXPECT_LT(errors.rms_px, 0.08);
}

TEST(BoardDetector, FindsTheGridWithOneBlackCellToo) {
  Target target;
  target.border_cells = 1;
  const Errors errors = detect_and_compare(target);
  EXPECT_EQ(errors.found, 144U);
  EXPECT_LT(errors.rms_px, 0.08);
}

TEST(BoardDetector, FindsAChessboardFromTheSameEndHoweverItIsHeld) {
  Target target;
  target.kind = TargetKind::kChessboard;
  target.rows = 6;
  target.columns = 9;
  target.row_m = target.column_m = 0.05;
  const RigEstimate rig = simulated_rig(DistortionModel::kRadialTangential);
  const sim::CameraModel camera(rig.cameras[0]);
  const LensParameters lens = to_parameters(rig.cameras[0]);
  for (const double turn_rad : {0.0, 1.6, 3.1, -1.6}) {
    Pose T = held_board(target, 0.7);
    const Pose about(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()));
    T.linear() = about.linear() * T.linear();
    const Eigen::Vector2d middle_m = 0.5 * target.size_m();
    T.translation() = Eigen::Vector3d(0, 0, 0.7) - T.linear() * Eigen::Vector3d(middle_m.x(), middle_m.y(), 0);
    const Corners corners = BoardDetector(target).detect(draw_board(target, camera, T, 4));
    ASSERT_EQ(corners.size(), 54U) << turn_rad;
    for (const Corner& corner : corners) {
      const Eigen::Vector2d b = target.corner_m(corner.index);
      const Eigen::Vector3d p = T * Eigen::Vector3d(b.x(), b.y(), 0);
      Eigen::Vector2d px;
      project(rig.cameras[0].distortion, lens.data(), p.data(), px.data());
      EXPECT_LT((px - corner.px).norm(), 0.3) << turn_rad << " corner " << corner.index;
    }
  }
}

TEST(BoardDetector, SeesNoBoardOfTheOtherBorderAndNoneInNoise) {
  Target one;
  one.border_cells = 1;
  const RigEstimate rig = simulated_rig(DistortionModel::kRadialTangential);
  const cv::Mat1b picture = draw_board(one, sim::CameraModel(rig.cameras[0]), held_board(one, 0.8), 5);
  EXPECT_TRUE(BoardDetector(Target{}).detect(picture).empty());
  cv::Mat1b noise(480, 640);
  cv::RNG(7).fill(noise, cv::RNG::UNIFORM, 0, 256);
  EXPECT_TRUE(BoardDetector(Target{}).detect(noise).empty());
}

TEST(BoardDetector, FindsThePublicGridThatTheStockDetectorDoesNotSee) {
  const char* data = std::getenv("ARPENT_DATA");
  if (data == nullptr) GTEST_SKIP() << "ARPENT_DATA is not set";
  const std::string file = std::string(data) + "/stereo/apriltag/yac_mocap/cam0/data/1606154022959313869.jpg";
  const cv::Mat1b image = cv::imread(file, cv::IMREAD_GRAYSCALE);
  ASSERT_FALSE(image.empty());
  tags::DetectorParams stock;
  stock.decimate = 1;
  EXPECT_LE(tags::TagDetector(stock).detect(image).size(), 1U);
  EXPECT_GE(BoardDetector(Target{}).detect(image).size(), 4U * 35U);
}

}  // namespace
}  // namespace arpent::calib
