// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/mapping/tsdf/workload.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace arpent::bench {
namespace {

using std::numbers::pi;
constexpr double kNearestM = 0.3;
constexpr double kFarthestM = 5.0;
constexpr double kBaselineM = 0.26;
constexpr double kDisparityNoisePx = 0.1;

/// Where the ray enters the box, or infinity.
double enter(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const Eigen::Vector3d& half) {
  double first = 0;
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double a = (-half[k] - origin[k]) / direction[k];
    const double b = (half[k] - origin[k]) / direction[k];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first < last && first > 0 ? first : std::numeric_limits<double>::infinity();
}

double signed_power(double x, double exponent) {
  return std::copysign(std::pow(std::abs(x), exponent), x);
}

Eigen::Vector3d path_point(double i) {
  const double a = 2 * pi * i / kPoses;
  return {10.5 + 8.0 * signed_power(std::cos(a), 0.6), 7 + 4.3 * signed_power(std::sin(a), 0.6), 0.8};
}

/// Distance from a point to the surface of an axis-aligned box around the origin.
double box_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& half) {
  const Eigen::Vector3d beyond = p.cwiseAbs() - half;
  return beyond.maxCoeff() < 0 ? -beyond.maxCoeff() : beyond.cwiseMax(0.0).norm();
}

}  // namespace

Eigen::Vector3d YawedBox::to_own(const Eigen::Vector3d& d) const {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  return {c * d.x() + s * d.y(), -s * d.x() + c * d.y(), d.z()};
}

Room::Room()
    : pillars_{{{6.0, 7.0}, 0.35}, {{10.5, 7.2}, 0.30}, {{15.2, 6.8}, 0.40}},
      boxes_{{{1.2, 1.3, .5}, {.5, .6, .5}, .3},     {{5.5, .9, .4}, {.8, .4, .4}, 0},
             {{10.8, 1, .6}, {.4, .5, .6}, .7},      {{16.5, 1.1, .35}, {.7, .5, .35}, -.4},
             {{19.6, 12.6, .75}, {.5, .5, .75}, .2}, {{13, 13, .3}, {1, .4, .3}, .1},
             {{8.2, 9, .45}, {.45, .35, .45}, 1.0},  {{12.8, 5.2, .55}, {.4, .4, .55}, -.8}},
      T_map_scene_(Pose::Identity()) {
  T_map_scene_.linear() = Eigen::AngleAxisd(10 * pi / 180, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_map_scene_.translation() = Eigen::Vector3d(0.037, 0.061, 0.023);
}

double Room::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  double range = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double wall = direction[k] > 0 ? size_[k] : 0.0;
    if (direction[k] != 0) range = std::min(range, (wall - origin[k]) / direction[k]);
  }
  for (const Pillar& pillar : pillars_) {
    const Eigen::Vector2d o = origin.head<2>() - pillar.centre;
    const Eigen::Vector2d d = direction.head<2>();
    const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - pillar.radius * pillar.radius;
    const double root = b * b - a * c;
    if (root < 0) continue;
    const double t = (-b - std::sqrt(root)) / a;
    if (t > 0) range = std::min(range, t);
  }
  for (const YawedBox& box : boxes_) {
    range = std::min(range, enter(box.to_own(origin - box.centre), box.to_own(direction), box.half));
  }
  return range;
}

double Room::distance(const Eigen::Vector3d& p) const {
  double nearest = box_distance(p - size_ / 2, size_ / 2);
  for (const Pillar& pillar : pillars_) {
    nearest = std::min(nearest, std::abs((p.head<2>() - pillar.centre).norm() - pillar.radius));
  }
  for (const YawedBox& box : boxes_) nearest = std::min(nearest, box_distance(box.to_own(p - box.centre), box.half));
  return nearest;
}

bool Room::inside_obstacle(const Eigen::Vector3d& p) const {
  constexpr double kSkinM = 1e-6;
  return std::any_of(pillars_.begin(), pillars_.end(),
                     [&](const Pillar& c) { return (p.head<2>() - c.centre).norm() < c.radius - kSkinM; }) ||
         std::any_of(boxes_.begin(), boxes_.end(), [&](const YawedBox& b) {
           return (b.to_own(p - b.centre).cwiseAbs() - b.half).maxCoeff() < (p.z() <= 0 ? kSkinM : -kSkinM);
         });
}

std::vector<Eigen::Vector3d> Room::sample_surface(double spacing) const {
  std::vector<Eigen::Vector3d> samples;
  const auto add = [&](const Eigen::Vector3d& p) {
    if (!inside_obstacle(p)) samples.push_back(p);
  };
  /// All six faces of a box with half edges `half`, as points in its own frame.
  const auto faces = [&](const Eigen::Vector3d& half, const auto& emit) {
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      for (double a = -half[i] + spacing / 2; a < half[i]; a += spacing) {
        for (double b = -half[j] + spacing / 2; b < half[j]; b += spacing) {
          for (const double side : {-half[k], half[k]}) {
            Eigen::Vector3d p;
            p[k] = side;
            p[i] = a;
            p[j] = b;
            emit(p);
          }
        }
      }
    }
  };
  faces(size_ / 2, [&](const Eigen::Vector3d& p) { add(p + size_ / 2); });
  for (const YawedBox& box : boxes_) {
    faces(box.half, [&](const Eigen::Vector3d& p) {
      if (p.z() == -box.half.z()) return;  // it stands on the floor
      const YawedBox back{box.centre, box.half, -box.yaw_rad};
      add(box.centre + back.to_own(p));
    });
  }
  for (const Pillar& pillar : pillars_) {
    const double step = spacing / pillar.radius;
    for (double a = 0; a < 2 * pi; a += step) {
      for (double z = spacing / 2; z < size_.z(); z += spacing) {
        add({pillar.centre.x() + pillar.radius * std::cos(a), pillar.centre.y() + pillar.radius * std::sin(a), z});
      }
    }
  }
  return samples;
}

PinholeCamera workload_camera() {
  return {640, 512, 376, 376, 319.5, 255.5};
}

Pose T_scene_cam_at(int i) {
  constexpr double kStep = 1e-3;
  const Eigen::Vector3d tangent = path_point(i + kStep) - path_point(i - kStep);
  const double heading = std::atan2(tangent.y(), tangent.x()) + 0.6 * std::sin(2 * pi * i / 12.5);
  Pose T_scene_body = Pose::Identity();
  T_scene_body.linear() = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_scene_body.translation() = path_point(i);
  Pose T_scene_cam = T_scene_body;
  T_scene_cam.linear() = T_scene_body.linear() * R_body_from_camera_axes();
  return T_scene_cam;
}

stereo::DepthMap DepthSequence::next() {
  const PinholeCamera camera = workload_camera();
  const Pose T_scene_cam = T_scene_cam_at(i_++);
  stereo::DepthMap map{camera, cv::Mat1f(camera.height_px, camera.width_px, 0.0F),
                       cv::Mat1f(camera.height_px, camera.width_px, 0.0F)};
  std::normal_distribution<double> normal;
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      const Eigen::Vector3d ray((u - camera.cx_px) / camera.fx_px, (v - camera.cy_px) / camera.fy_px, 1);
      const double z = room_.cast(T_scene_cam.translation(), T_scene_cam.linear() * ray);
      const double sigma = kDisparityNoisePx * z * z / (camera.fx_px * kBaselineM);
      const double measured = z + sigma * normal(random_);
      if (measured < kNearestM || measured > kFarthestM) continue;
      map.depth_m(v, u) = static_cast<float>(measured);
      map.sigma_m(v, u) = static_cast<float>(sigma);
    }
  }
  return map;
}

std::vector<Eigen::Vector3d> keep_observed(const Room& room, const std::vector<Eigen::Vector3d>& samples) {
  const PinholeCamera camera = workload_camera();
  std::vector<Pose> T_cam_scene;
  for (int i = 0; i < kPoses; ++i) T_cam_scene.push_back(T_scene_cam_at(i).inverse());
  std::vector<Eigen::Vector3d> observed;
  for (const Eigen::Vector3d& p : samples) {
    const bool seen = std::any_of(T_cam_scene.begin(), T_cam_scene.end(), [&](const Pose& T) {
      const Eigen::Vector3d q = T * p;
      if (q.z() < kNearestM || q.z() > kFarthestM) return false;
      const Eigen::Vector2d pixel = camera.project(q);
      if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > camera.width_px - 1 || pixel.y() > camera.height_px - 1) {
        return false;
      }
      const Eigen::Vector3d eye = T.inverse().translation();
      return room.cast(eye, (p - eye) / q.z()) > q.z() - 1e-3;
    });
    if (seen) observed.push_back(p);
  }
  return observed;
}

}  // namespace arpent::bench
