// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/world/pictures.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/error.h"
#include "sim/camera/renderer.h"
#include "sim/world/ground.h"
#include "tools/report/html.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;

/// From ground coordinates to pixels of a plan of at most 800 pixels.
struct Plan {
  sim::Region region;
  double px_per_m = 1;

  explicit Plan(const sim::Region& r) : region(r) {
    const Eigen::Vector3d size = r.max_m - r.min_m;
    px_per_m = 800 / std::max(size.x(), size.y());
  }
  [[nodiscard]] cv::Point at(const Eigen::Vector2d& p) const {
    return {static_cast<int>(std::lround(px_per_m * (p.x() - region.min_m.x()))),
            static_cast<int>(std::lround(px_per_m * (region.max_m.y() - p.y())))};
  }
  [[nodiscard]] cv::Size size() const {
    const cv::Point corner = at({region.max_m.x(), region.min_m.y()});
    return {corner.x + 1, corner.y + 1};
  }
};

void draw_robot(cv::Mat3b& picture, const Plan& plan, const Pose2& pose, const cv::Scalar& colour) {
  const sim::EllipseFootprint footprint;
  const cv::Size axes(static_cast<int>(plan.px_per_m * footprint.semi_long_m),
                      static_cast<int>(plan.px_per_m * footprint.semi_short_m));
  cv::ellipse(picture, plan.at(pose.position_m()), axes, -pose.yaw_rad * 180 / CV_PI, 0, 360, colour, 2, cv::LINE_AA);
  const Eigen::Vector2d nose =
      pose.position_m() + 0.55 * Eigen::Vector2d(std::cos(pose.yaw_rad), std::sin(pose.yaw_rad));
  cv::line(picture, plan.at(pose.position_m()), plan.at(nose), colour, 2, cv::LINE_AA);
}

cv::Mat3b draw_plan(const sim::World& world, const sim::Renderer& renderer, const Pose2& pose) {
  const Plan plan(world.region);
  cv::Mat3b picture(plan.size());
  const double eye_m = std::min(0.5, world.region.max_m.z());
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      const Eigen::Vector3d from(world.region.min_m.x() + u / plan.px_per_m, world.region.max_m.y() - v / plan.px_per_m,
                                 eye_m);
      const double light = renderer.irradiance(from, -Eigen::Vector3d::UnitZ()).value_or(0);
      const auto level = static_cast<std::uint8_t>(std::clamp(110 * light, 20.0, 235.0));
      picture(v, u) = cv::Vec3b(level, level, level);
    }
  }
  const sim::GroundMap ground(world);
  for (const auto& obstacle : ground.obstacles()) {
    std::vector<cv::Point> corners;
    for (const Eigen::Vector2d& p : obstacle) corners.push_back(plan.at(p));
    cv::fillPoly(picture, std::vector<std::vector<cv::Point>>{corners}, cv::Scalar(80, 60, 40), cv::LINE_AA);
    cv::polylines(picture, corners, true, cv::Scalar(30, 30, 200), 2, cv::LINE_AA);
  }
  for (const Pose2& start : world.starts) draw_robot(picture, plan, start, cv::Scalar(60, 170, 60));
  draw_robot(picture, plan, pose, cv::Scalar(200, 120, 0));
  return picture;
}

void write(const fs::path& file, const cv::Mat& picture) {
  if (!cv::imwrite(file.string(), picture)) throw InputError("cannot write " + file.string());
}

}  // namespace

WorldPictures draw_world(const sim::World& world, const Rig& rig, const Pose2& pose) {
  const sim::Renderer renderer(world);
  const StereoCalibration& calibration = rig.calibration;
  const Pose T_world_left = pose.to_pose() * calibration.T_body_left;
  const Pose T_world_right = T_world_left * calibration.T_right_left.inverse();
  sim::CameraShot shot;
  const auto left = renderer.render(sim::CameraModel(calibration.left), T_world_left, shot);
  shot.seed = 1;
  const auto right = renderer.render(sim::CameraModel(calibration.right), T_world_right, shot);
  return {left.image, right.image, report::colour(left.depth_m, rig.config.min_range_m, 2 * rig.config.max_range_m),
          draw_plan(world, renderer, pose)};
}

void write_pictures(const WorldPictures& pictures, const fs::path& out) {
  if (out.extension() != ".png") {
    std::error_code error;
    fs::create_directories(out, error);
    if (error) throw InputError("cannot make the folder " + out.string() + ": " + error.message());
    write(out / "left.png", pictures.left);
    write(out / "right.png", pictures.right);
    write(out / "depth.png", pictures.depth);
    write(out / "top.png", pictures.top);
    return;
  }
  cv::Mat3b left, right, top, sheet;
  cv::cvtColor(pictures.left, left, cv::COLOR_GRAY2BGR);
  cv::cvtColor(pictures.right, right, cv::COLOR_GRAY2BGR);
  const cv::Size size = left.size();
  cv::resize(pictures.top, top, {},
             std::min(1.0 * size.width / pictures.top.cols, 1.0 * size.height / pictures.top.rows),
             std::min(1.0 * size.width / pictures.top.cols, 1.0 * size.height / pictures.top.rows), cv::INTER_AREA);
  cv::copyMakeBorder(top, top, 0, size.height - top.rows, 0, size.width - top.cols, cv::BORDER_CONSTANT);
  cv::Mat3b upper, lower;
  cv::hconcat(left, right, upper);
  cv::hconcat(pictures.depth, top, lower);
  cv::vconcat(upper, lower, sheet);
  write(out, sheet);
}

}  // namespace arpent::tools
