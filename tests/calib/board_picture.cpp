// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/calib/board_picture.h"

#include <Eigen/LU>
#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "calib/artwork.h"

namespace arpent::calib {
namespace {

constexpr double kCellM = 0.0004;  // of the bitmap of the artwork
constexpr float kBlack = 30, kWhite = 200, kRoom = 110;
constexpr int kSamples = 4;  // along each side of a pixel

/// The artwork as a bitmap, row 0 at the lowest y, white paper around it.
struct Bitmap {
  cv::Mat1f level;
  double x_m, y_m;

  explicit Bitmap(const Target& target) {
    const auto black = black_rectangles(target);
    double low_x = 1e9, low_y = 1e9, high_x = -1e9, high_y = -1e9;
    for (const BlackRectangle& r : black) {
      low_x = std::min(low_x, r.x_m), low_y = std::min(low_y, r.y_m);
      high_x = std::max(high_x, r.x_m + r.width_m), high_y = std::max(high_y, r.y_m + r.height_m);
    }
    constexpr double kPaperM = 0.02;
    x_m = low_x - kPaperM, y_m = low_y - kPaperM;
    level = cv::Mat1f(index(high_y + kPaperM - y_m), index(high_x + kPaperM - x_m), kWhite);
    for (const BlackRectangle& r : black) {
      level(cv::Range(index(r.y_m - y_m), index(r.y_m + r.height_m - y_m)),
            cv::Range(index(r.x_m - x_m), index(r.x_m + r.width_m - x_m))) = kBlack;
    }
  }
  static int index(double m) { return static_cast<int>(std::lround(m / kCellM)); }
  [[nodiscard]] float at(double bx_m, double by_m) const {
    const int column = static_cast<int>(std::floor((bx_m - x_m) / kCellM));
    const int row = static_cast<int>(std::floor((by_m - y_m) / kCellM));
    if (column < 0 || row < 0 || column >= level.cols || row >= level.rows) return kRoom;
    return level(row, column);
  }
};

}  // namespace

cv::Mat1b draw_board(const Target& target, const sim::CameraModel& camera, const Pose& T_cam_board,
                     std::uint64_t seed) {
  const Bitmap bitmap(target);
  Eigen::Matrix3d H;  // board plane to rays
  H << T_cam_board.linear().leftCols<2>(), T_cam_board.translation();
  const Eigen::Matrix3d to_board = H.inverse();
  const int width = camera.width_px(), height = camera.height_px();
  cv::Mat1f light(height, width, kRoom);
  const auto ray = [&](int u, int v) {
    const auto i = static_cast<std::size_t>(std::clamp(v, 0, height - 1) * width + std::clamp(u, 0, width - 1));
    return Eigen::Vector2d(camera.ray_x()[i], camera.ray_y()[i]);
  };
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector2d middle = ray(u, v), along = 0.5 * (ray(u + 1, v) - ray(u - 1, v)),
                            down = 0.5 * (ray(u, v + 1) - ray(u, v - 1));
      float sum = 0;
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const double a = (s % kSamples + 0.5) / kSamples - 0.5, b = (s / kSamples + 0.5) / kSamples - 0.5;
        const Eigen::Vector3d p = to_board * (middle + a * along + b * down).homogeneous();
        sum += p.z() > 0 ? bitmap.at(p.x() / p.z(), p.y() / p.z()) : kRoom;
      }
      light(v, u) = sum / (kSamples * kSamples);
    }
  }
  cv::GaussianBlur(light, light, {0, 0}, 0.6);
  cv::Mat1f noise(light.size());
  cv::RNG random(seed + 1);
  random.fill(noise, cv::RNG::NORMAL, 0, 1.5);
  cv::Mat1b image;
  cv::Mat1f(light + noise).convertTo(image, CV_8U);
  return image;
}

}  // namespace arpent::calib
