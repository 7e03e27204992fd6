// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include "common/error.h"
#include "perception/stereo/alignment.h"
#include "perception/stereo/calibration_file.h"
#include "perception/stereo/depth.h"
#include "perception/stereo/fill.h"
#include "perception/stereo/matcher.h"
#include "perception/stereo/rectifier.h"
#include "perception/stereo/wire.h"
#include "tests/perception/stereo/pictures.h"

namespace arpent::stereo {
namespace {

using testing::HasSubstr;

StereoCalibration ideal() {
  StereoCalibration calibration;
  calibration.left.pinhole = {320, 256, 188, 188, 159.5, 127.5};
  calibration.right = calibration.left;
  calibration.T_right_left.translation().x() = -0.26;
  return calibration;
}

TEST(StereoRectifier, AnIdealPairPassesUntouched) {
  const Rectifier rectifier(ideal());
  EXPECT_TRUE(rectifier.is_identity());
  const cv::Mat1b left = texture(256, 320, 1), right = texture(256, 320, 2);
  const auto [l, r] = rectifier.rectify(left, right);
  EXPECT_EQ(l.data, left.data);
  EXPECT_EQ(r.data, right.data);
  EXPECT_DOUBLE_EQ(rectifier.stereo().baseline_m, 0.26);
}

/// Pixel of a point [m] in a raw camera with radial-tangential distortion, written out from the model's definition.
Eigen::Vector2d raw_pixel(const RawCamera& camera, const Eigen::Vector3d& p) {
  const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
  const auto& [k1, k2, p1, p2, k3] = camera.coefficients;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {camera.pinhole.fx_px * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + camera.pinhole.cx_px,
          camera.pinhole.fy_px * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + camera.pinhole.cy_px};
}

TEST(StereoRectifier, ARawPairBecomesThatOfAnIdealCamera) {
  StereoCalibration calibration = ideal();
  for (RawCamera* camera : {&calibration.left, &calibration.right}) {
    camera->distortion = DistortionModel::kRadialTangential;
    camera->coefficients = {-0.2, 0.05, 1e-3, -5e-4, 0.0};
  }
  calibration.right.pinhole.fx_px = 190;
  calibration.T_right_left.linear() = so3_exp({0.01, -0.02, 0.015});
  const Rectifier rectifier(calibration);
  EXPECT_FALSE(rectifier.is_identity());
  const RectifiedStereo stereo = rectifier.stereo();
  const Eigen::Matrix3d R_left_rectified =
      calibration.T_body_left.linear().transpose() * rectifier.T_body_rectified().linear();
  for (const Eigen::Vector3d& p_rectified :
       {Eigen::Vector3d(0.1, 0.2, 2.0), Eigen::Vector3d(-0.5, -0.3, 3.0), Eigen::Vector3d(0.7, 0.5, 4.0)}) {
    const Eigen::Vector3d p_left = R_left_rectified * p_rectified;
    cv::Mat1b left(256, 320, std::uint8_t{0}), right(256, 320, std::uint8_t{0});
    const auto mark = [](cv::Mat1b& image, const Eigen::Vector2d& at) {
      cv::circle(image, cv::Point(cvRound(at.x() * 16), cvRound(at.y() * 16)), 4 * 16, cv::Scalar(255), cv::FILLED,
                 cv::LINE_AA, 4);
    };
    mark(left, raw_pixel(calibration.left, p_left));
    mark(right, raw_pixel(calibration.right, calibration.T_right_left * p_left));
    const auto [l, r] = rectifier.rectify(left, right);
    const auto centre = [](const cv::Mat1b& image) {
      const cv::Moments m = cv::moments(image);
      return Eigen::Vector2d(m.m10 / m.m00, m.m01 / m.m00);
    };
    const Eigen::Vector2d wanted = stereo.camera.project(p_rectified);
    EXPECT_LT((centre(l) - wanted).norm(), 0.25);
    EXPECT_LT(
        (centre(r) - wanted + Eigen::Vector2d(stereo.baseline_m * stereo.camera.fx_px / p_rectified.z(), 0)).norm(),
        0.25);
  }
}

TEST(StereoDepth, IsBaselineTimesFocalLengthOverDisparityWithinTheRange) {
  const RectifiedStereo stereo{{4, 1, 200, 200, 2, 0}, 0.5};
  cv::Mat1w px128(1, 4);
  px128(0) = 50 * 128;  // z = 100 / 50 = 2 m
  px128(1) = kMissing;
  px128(2) = 10 * 128;   // 10 m: beyond the range
  px128(3) = 400 * 128;  // 0.25 m: before the range
  const DepthMap depth = depth_from_disparity(px128, cv::Mat1f(1, 4, 0.25F), stereo, 0.3, 5.0);
  EXPECT_FLOAT_EQ(depth.depth_m(0), 2.0F);
  EXPECT_FLOAT_EQ(depth.sigma_m(0), 2.0F * 2.0F * 0.25F / 100.0F);
  for (int i = 1; i < 4; ++i) EXPECT_EQ(depth.depth_m(i), 0) << i;
}

TEST(StereoAlignment, AVerticalShiftIsMeasured) {
  const cv::Mat1b left = texture(240, 320, 4);
  const cv::Mat1w disparity(left.size(), std::uint16_t{10 * 128});
  for (const double dy : {0.0, 0.5, 1.0, -1.0, 2.0}) {
    cv::Mat1b right;
    const cv::Mat1d shift = (cv::Mat1d(2, 3) << 1, 0, -10, 0, 1, dy);
    cv::warpAffine(left, right, shift, left.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
    EXPECT_NEAR(measure_vertical_offset_px(left, right, disparity), dy, 0.15);
  }
  const cv::Mat1b flat(left.size(), std::uint8_t{90});
  EXPECT_TRUE(std::isnan(measure_vertical_offset_px(flat, flat, disparity)));
}

TEST(StereoFill, GapsTakeTheFartherEnd) {
  cv::Mat1w row = (cv::Mat1w(3, 5) << kMissing, kMissing, kMissing, kMissing, kMissing,  //
                   100, kMissing, kMissing, 50, kMissing,                                //
                   kMissing, 7, kMissing, 9, kMissing);
  fill_from_background(row);
  const cv::Mat1w wanted = (cv::Mat1w(3, 5) << 100, 50, 50, 50, 50, 100, 50, 50, 50, 50, 7, 7, 7, 9, 9);
  EXPECT_EQ(cv::norm(row, wanted, cv::NORM_INF), 0);
  cv::Mat1w empty(3, 3, kMissing);
  fill_from_background(empty);
  EXPECT_EQ(cv::countNonZero(empty == kMissing), 9);
}

MatcherParams params(int range) {
  MatcherParams p;
  p.max_disparity_px = range;
  return p;
}

TEST(StereoMatcher, ARenderedArenaIsMeasuredRight) {
  const ArenaPair pair;
  const auto disparities = make_matcher(params(128))->match(pair.left.image, pair.right.image);
  int known = 0, bad = 0, truth = 0;
  for (int v = 0; v < pair.camera.height_px; ++v) {
    for (int u = 0; u < pair.camera.width_px; ++u) {
      if (pair.left.depth_m(v, u) <= 0) continue;
      ++truth;
      if (disparities.trusted(v, u) == kMissing) continue;
      ++known;
      const double d = pair.disparity_px(v, u);
      bad += std::abs(disparities.trusted(v, u) / 128.0 - d) > 2 ? 1 : 0;
    }
  }
  EXPECT_GT(known, truth * 7 / 10);
  EXPECT_LT(bad, known * 3 / 100);
  EXPECT_LT(std::abs(disparities.vertical_offset_px), 0.2);
}

TEST(StereoMatcher, PairsWithoutTextureGiveADefinedEmptyResult) {
  for (const std::uint8_t level : {std::uint8_t{0}, std::uint8_t{90}, std::uint8_t{255}}) {
    const cv::Mat1b flat(64, 96, level);
    const auto disparities = make_matcher(params(32))->match(flat, flat);
    EXPECT_EQ(cv::countNonZero(disparities.trusted != kMissing), 0);
    EXPECT_EQ(cv::countNonZero(disparities.filled != kMissing), 0);
    EXPECT_TRUE(std::isnan(disparities.vertical_offset_px));
  }
}

TEST(StereoMatcher, OddPairsAreDefinedAndTheSameEachTime) {
  const cv::Mat1b small = texture(32, 32, 1), other = texture(32, 32, 2);
  for (const auto& [l, r] : {std::pair(small, small), std::pair(small, other), std::pair(other, small)}) {
    const auto matcher = make_matcher(params(327));
    const auto first = matcher->match(l, r);
    const auto second = matcher->match(l, r);
    EXPECT_EQ(cv::norm(first.trusted, second.trusted, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(first.filled, second.filled, cv::NORM_INF), 0);
    EXPECT_EQ(first.filled.size(), l.size());
  }
  EXPECT_THROW((void)make_matcher(params(5)), InputError);
}

class StereoCalibrationFile : public testing::Test {
 protected:
  std::string file_ = testing::TempDir() + testing::UnitTest::GetInstance()->current_test_info()->name() + ".yaml";
  void put(const std::string& text) const { std::ofstream(file_) << text; }
  std::string fault() const {
    try {
      (void)read_calibration(file_, 640, 480);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

constexpr const char* kKalibr = R"(cam0:
  camera_model: pinhole
  distortion_coeffs: [-0.3, 0.1, 0.001, 0.0002]
  distortion_model: radtan
  intrinsics: [461.6, 460.3, 362.7, 248.1]
  resolution: [752, 480]
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.11]
  - [0.0, 1.0, 0.0, 0.001]
  - [0.0, 0.0, 1.0, 0.002]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.09, 0.001, 0.0002]
  distortion_model: radtan
  intrinsics: [460.6, 459.3, 379.7, 255.1]
  resolution: [752, 480]
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST_F(StereoCalibrationFile, KalibrsCamchainIsRead) {
  put(kKalibr);
  const auto calibration = read_calibration(file_, 0, 0);
  EXPECT_EQ(calibration.left.pinhole, (PinholeCamera{752, 480, 461.6, 460.3, 362.7, 248.1}));
  EXPECT_EQ(calibration.right.distortion, DistortionModel::kRadialTangential);
  EXPECT_DOUBLE_EQ(calibration.right.coefficients[0], -0.28);
  EXPECT_DOUBLE_EQ(calibration.T_right_left.translation().x(), -0.11);
}

TEST_F(StereoCalibrationFile, UnusableCalibrationsAreNamed) {
  put(replaced(kKalibr, "461.6", ".nan"));
  EXPECT_THAT(fault(), HasSubstr("finite"));
  put(replaced(kKalibr, "461.6", "-461.6"));
  EXPECT_THAT(fault(), HasSubstr("focal length"));
  put(replaced(kKalibr, "-0.11", "0.11"));
  EXPECT_THAT(fault(), HasSubstr("swapped"));
  put(replaced(kKalibr, "radtan", "fov"));
  EXPECT_THAT(fault(), HasSubstr("distortion_model"));
  put(replaced(kKalibr, "cam1:", "camX:"));
  EXPECT_FALSE(fault().empty());
}

TEST_F(StereoCalibrationFile, OpenCvsFileIsRead) {
  cv::FileStorage out(file_, cv::FileStorage::WRITE);
  const cv::Mat1d K = (cv::Mat1d(3, 3) << 500, 0, 320, 0, 501, 240, 0, 0, 1);
  const cv::Mat1d D = (cv::Mat1d(1, 5) << 0.1, -0.2, 0.001, 0.002, 0.05);
  out << "image_width" << 640 << "image_height" << 480 << "M1" << K << "D1" << D << "M2" << K << "D2" << D;
  out << "R" << cv::Mat1d(cv::Mat1d::eye(3, 3)) << "T" << cv::Mat1d((cv::Mat1d(3, 1) << -0.1, 0, 0));
  out.release();
  const auto calibration = read_calibration(file_, 0, 0);
  EXPECT_EQ(calibration.left.pinhole, (PinholeCamera{640, 480, 500, 501, 320, 240}));
  EXPECT_DOUBLE_EQ(calibration.left.coefficients[4], 0.05);
  EXPECT_DOUBLE_EQ(calibration.T_right_left.translation().x(), -0.1);
}

TEST(StereoWire, EveryFieldOfDepthAndDisparitySurvives) {
  StampedDepth depth{from_utime(12),
                     34,
                     {{3, 2, 5, 6, 1, 0.5},
                      (cv::Mat1f(2, 3) << 0, 1.5, 2.25, 3.125, 60, 70),
                      (cv::Mat1f(2, 3) << 0, .01, .02, .03, 5, 9)}};
  const auto back = from_wire(to_wire(depth));
  ASSERT_TRUE(back) << back.fault();
  EXPECT_EQ(back->stamp, depth.stamp);
  EXPECT_EQ(back->sequence, 34);
  EXPECT_EQ(back->map.camera, depth.map.camera);
  EXPECT_NEAR(back->map.depth_m(1, 0), 3.125, 5.1e-4);
  EXPECT_EQ(back->map.depth_m(1, 2), 0) << "70 m do not fit in 16 bits of millimetres";
  EXPECT_NEAR(back->map.sigma_m(0, 2), 0.02, 5.1e-5);
  const RectifiedStereo stereo{{3, 2, 5, 6, 1, 0.5}, 0.26};
  const cv::Mat1w px128 = (cv::Mat1w(2, 3) << 1, 2, 3, 4, 5, kMissing);
  const auto disparity = from_wire(to_wire(from_utime(7), 8, DisparityKind::kFilled, stereo, 0.1, px128));
  ASSERT_TRUE(disparity) << disparity.fault();
  EXPECT_EQ(disparity->stereo, stereo);
  EXPECT_EQ(disparity->kind, DisparityKind::kFilled);
  EXPECT_EQ(cv::norm(disparity->px128, px128, cv::NORM_INF), 0);
}

TEST(StereoWire, ImpossibleMessagesAreRefused) {
  const RectifiedStereo stereo{{3, 2, 5, 6, 1, 0.5}, 0.26};
  const disparity_t good =
      to_wire(from_utime(7), 8, DisparityKind::kFilled, stereo, 0.1, cv::Mat1w(2, 3, std::uint16_t{5}));
  disparity_t bad = good;
  bad.fx_px = -5;
  EXPECT_FALSE(from_wire(bad));
  bad = good;
  bad.kind = 9;
  EXPECT_FALSE(from_wire(bad));
  bad = good;
  bad.baseline_m = std::nan("");
  EXPECT_FALSE(from_wire(bad));
}

}  // namespace
}  // namespace arpent::stereo
