// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/rectifier.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "common/error.h"

namespace arpent::stereo {
namespace {

cv::Matx33d camera_matrix(const PinholeCamera& camera) {
  return {camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1};
}

cv::Matx33d to_cv(const Eigen::Matrix3d& R) {
  cv::Matx33d matrix;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) matrix(r, c) = R(r, c);
  }
  return matrix;
}

Eigen::Matrix3d to_eigen(const cv::Matx33d& R) {
  Eigen::Matrix3d matrix;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) matrix(r, c) = R(r, c);
  }
  return matrix;
}

/// The same pixels seen without lens distortion, so that stereoRectify (radial-tangential only) serves both lens
/// models: the rotation that it chooses depends on T_right_left alone.
struct Rectification {
  cv::Matx33d R_left, R_right;
  PinholeCamera camera;
};

Rectification choose(const StereoCalibration& calibration) {
  const PinholeCamera& left = calibration.left.pinhole;
  const cv::Matx33d R = to_cv(calibration.T_right_left.linear());
  const Eigen::Vector3d t = calibration.T_right_left.translation();
  const cv::Size size(left.width_px, left.height_px);
  const auto coefficients = [](const RawCamera& camera) {
    return camera.distortion == DistortionModel::kRadialTangential
               ? cv::Mat(cv::Mat1d(1, 5, const_cast<double*>(camera.coefficients.data())).clone())
               : cv::Mat();
  };
  Rectification result;
  cv::Matx34d P_left;
  cv::Matx34d P_right;
  cv::Matx44d Q;
  cv::stereoRectify(camera_matrix(left), coefficients(calibration.left), camera_matrix(calibration.right.pinhole),
                    coefficients(calibration.right), size, R, cv::Vec3d(t.x(), t.y(), t.z()), result.R_left,
                    result.R_right, P_left, P_right, Q, cv::CALIB_ZERO_DISPARITY, 0.0);
  result.camera = {size.width, size.height, P_left(0, 0), P_left(1, 1), P_left(0, 2), P_left(1, 2)};
  return result;
}

Remap make_map(const RawCamera& camera, const cv::Matx33d& R, const PinholeCamera& target) {
  cv::Mat1f u;
  cv::Mat1f v;
  const cv::Size size(target.width_px, target.height_px);
  const cv::Matx33d K = camera_matrix(camera.pinhole);
  const cv::Matx33d P = camera_matrix(target);
  if (camera.distortion == DistortionModel::kEquidistant) {
    const cv::Vec4d D(camera.coefficients[0], camera.coefficients[1], camera.coefficients[2], camera.coefficients[3]);
    cv::fisheye::initUndistortRectifyMap(K, D, R, P, size, CV_32FC1, u, v);
  } else {
    const cv::Mat1d D(1, 5, const_cast<double*>(camera.coefficients.data()));
    cv::initUndistortRectifyMap(K, D, R, P, size, CV_32FC1, u, v);
  }
  return {u, v, cv::Size(camera.pinhole.width_px, camera.pinhole.height_px)};
}

bool is_ideal(const StereoCalibration& calibration) {
  const Eigen::Vector3d t = calibration.T_right_left.translation();
  return calibration.left.distortion == DistortionModel::kNone &&
         calibration.right.distortion == DistortionModel::kNone &&
         calibration.left.pinhole == calibration.right.pinhole && calibration.T_right_left.linear().isIdentity(1e-12) &&
         std::abs(t.y()) < 1e-12 && std::abs(t.z()) < 1e-12;
}

}  // namespace

Rectifier::Rectifier(const StereoCalibration& calibration) {
  ARPENT_ASSERT(find_faults(calibration).empty());
  identity_ = is_ideal(calibration);
  stereo_.baseline_m = calibration.T_right_left.translation().norm();
  T_body_rectified_ = calibration.T_body_left;
  if (identity_) {
    stereo_.camera = calibration.left.pinhole;
    return;
  }
  const Rectification rectification = choose(calibration);
  stereo_.camera = rectification.camera;
  T_body_rectified_.linear() = calibration.T_body_left.linear() * to_eigen(rectification.R_left).transpose();
  maps_[0] = make_map(calibration.left, rectification.R_left, stereo_.camera);
  maps_[1] = make_map(calibration.right, rectification.R_right, stereo_.camera);
}

std::pair<cv::Mat1b, cv::Mat1b> Rectifier::rectify(const cv::Mat1b& left, const cv::Mat1b& right) const {
  if (identity_) return {left, right};
  return {maps_[0].apply(left), maps_[1].apply(right)};
}

}  // namespace arpent::stereo
