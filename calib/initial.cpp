// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/initial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "common/error.h"

namespace arpent::calib {
namespace {

/// Focal lengths over the image's width: fields of view from 118 to 14 degrees.
constexpr double kFocalRatios[] = {0.3, 0.42, 0.6, 0.85, 1.2, 1.7, 2.6, 4.0};
constexpr std::size_t kTrialViews = 12, kTrialCorners = 40;
constexpr double kRobustPx = 2;
constexpr double kMaxPlane = 4;  // beyond (76 degrees), a pinhole's plane coordinates are of no use

RawCamera first_guess(const CameraInput& input, DistortionModel model, double focal_ratio) {
  const double f_px = focal_ratio * input.width_px;
  RawCamera camera;
  camera.pinhole = {
      input.width_px, input.height_px, f_px, f_px, 0.5 * (input.width_px - 1), 0.5 * (input.height_px - 1)};
  camera.distortion = model;
  return camera;
}

/// The board's pose from one camera's corners; nullopt if they determine none.
std::optional<Pose> board_pose(const Target& target, const RawCamera& camera, const Corners& corners) {
  std::vector<cv::Point3d> board;
  std::vector<cv::Point2d> plane;
  for (const Corner& c : corners) {
    const auto x = unproject(camera, c.px);
    if (!x || x->norm() > kMaxPlane) continue;
    const Eigen::Vector2d b = target.corner_m(c.index);
    board.emplace_back(b.x(), b.y(), 0);
    plane.emplace_back(x->x(), x->y());
  }
  if (board.size() < 6) return std::nullopt;
  cv::Vec3d w, t;
  if (!cv::solvePnP(board, plane, cv::Matx33d::eye(), cv::noArray(), w, t)) return std::nullopt;
  Pose T = Pose::Identity();
  T.linear() = so3_exp({w[0], w[1], w[2]});
  T.translation() = Eigen::Vector3d(t[0], t[1], t[2]);
  if (!T.matrix().allFinite() || !(T.translation().z() > 0)) return std::nullopt;
  return T;
}

/// The one that lies most in the middle of all (least sum of distances).
Pose medoid(const std::vector<Pose>& poses) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    double sum = 0;
    for (const Pose& other : poses) {
      sum += (poses[i].translation() - other.translation()).norm() +
             so3_log(poses[i].linear().transpose() * other.linear()).norm();
    }
    if (sum < least) least = sum, best = i;
  }
  return poses[best];
}

using CameraPoses = std::vector<std::vector<std::optional<Pose>>>;  // [view][camera] T_cam_board

/// Cameras' places, each from the views that it shares with one whose place is known. False if one stays unconnected.
bool connect_cameras(const CameraPoses& T_cam_board, RigEstimate& rig) {
  std::vector<bool> known(rig.cameras.size(), false);
  known[0] = true;
  for (std::size_t round = 1; round < known.size(); ++round) {
    for (std::size_t c = 1; c < known.size(); ++c) {
      if (known[c]) continue;
      std::vector<Pose> found;
      for (const auto& view : T_cam_board) {
        for (std::size_t other = 0; other < known.size(); ++other) {
          if (!known[other] || !view[other] || !view[c]) continue;
          found.push_back(*view[c] * view[other]->inverse() * rig.T_cam_first[other]);
        }
      }
      if (found.empty()) continue;
      rig.T_cam_first[c] = medoid(found);
      known[c] = true;
    }
  }
  return std::all_of(known.begin(), known.end(), [](bool k) { return k; });
}

/// Board poses of all views, each from the camera that sees most of the board.
void place_boards(const BoardViews& views, const CameraPoses& T_cam_board, RigEstimate& rig) {
  rig.T_first_board.assign(views.views.size(), Pose::Identity());
  for (std::size_t v = 0; v < views.views.size(); ++v) {
    std::size_t most = 0;
    rig.T_first_board[v].translation().z() = 1;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      if (!T_cam_board[v][c] || views.views[v].cameras[c].size() <= most) continue;
      most = views.views[v].cameras[c].size();
      rig.T_first_board[v] = rig.T_cam_first[c].inverse() * *T_cam_board[v][c];
    }
  }
}

/// Geometry of a rig whose lenses are given. nullopt if a camera cannot be connected.
std::optional<RigEstimate> estimate_geometry(const BoardViews& views, const std::vector<RawCamera>& lenses) {
  RigEstimate rig{lenses, std::vector<Pose>(lenses.size(), Pose::Identity()), {}};
  CameraPoses T_cam_board;
  for (const View& view : views.views) {
    auto& poses = T_cam_board.emplace_back();
    for (std::size_t c = 0; c < lenses.size(); ++c)
      poses.push_back(board_pose(views.target, lenses[c], view.cameras[c]));
  }
  if (!connect_cameras(T_cam_board, rig)) return std::nullopt;
  place_boards(views, T_cam_board, rig);
  return rig;
}

/// Corners spread over the whole list: enough to tell one minimum from another.
void thin_out(Corners& corners) {
  if (corners.size() <= kTrialCorners) return;
  Corners kept;
  for (std::size_t i = 0; i < kTrialCorners; ++i) kept.push_back(corners[i * corners.size() / kTrialCorners]);
  corners = std::move(kept);
}

/// Views spread over the whole set, those that most cameras see first.
BoardViews trial_views(const BoardViews& views) {
  std::vector<std::size_t> order;
  const std::size_t step = std::max<std::size_t>(1, views.views.size() / kTrialViews);
  for (std::size_t first = 0; first < step; ++first) {
    for (std::size_t v = first; v < views.views.size(); v += step) order.push_back(v);
  }
  const auto seen = [&](std::size_t v) {
    const auto& cameras = views.views[v].cameras;
    return std::count_if(cameras.begin(), cameras.end(), [](const Corners& c) { return !c.empty(); });
  };
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return seen(a) > seen(b); });
  order.resize(std::min(order.size(), kTrialViews));
  std::sort(order.begin(), order.end());
  BoardViews trial{views.target, views.cameras, {}};
  for (const std::size_t v : order) {
    trial.views.push_back(views.views[v]);
    for (Corners& corners : trial.views.back().cameras) thin_out(corners);
  }
  return trial;
}

/// Cost per trial: the pinhole first, then with distortion, robustly.
double improve(const std::vector<Observation>& observations, RigEstimate& rig) {
  SolveOptions options{.fix_distortion = true, .cauchy_px = kRobustPx, .max_iterations = 25};
  if (!std::isfinite(solve(observations, rig, options))) return std::numeric_limits<double>::infinity();
  options.fix_distortion = false;
  options.max_iterations = 40;
  return solve(observations, rig, options);
}

bool is_plausible(const RigEstimate& rig) {
  return std::all_of(rig.cameras.begin(), rig.cameras.end(), [](const RawCamera& camera) {
    const PinholeCamera& p = camera.pinhole;
    return p.fx_px > 0.1 * p.width_px && p.fy_px > 0.1 * p.width_px && p.fx_px < 50.0 * p.width_px &&
           p.fy_px < 50.0 * p.width_px;
  });
}

}  // namespace

std::vector<Observation> to_observations(const BoardViews& views) {
  std::vector<Observation> observations;
  for (std::size_t v = 0; v < views.views.size(); ++v) {
    for (std::size_t c = 0; c < views.cameras.size(); ++c) {
      for (const Corner& corner : views.views[v].cameras[c]) {
        observations.push_back(
            {static_cast<int>(v), static_cast<int>(c), corner.index, views.target.corner_m(corner.index), corner.px});
      }
    }
  }
  return observations;
}

RigEstimate initial_estimate(const BoardViews& views, DistortionModel model) {
  const BoardViews trial = trial_views(views);
  const std::vector<Observation> observations = to_observations(trial);
  std::optional<RigEstimate> best;
  double least = std::numeric_limits<double>::infinity();
  for (const double ratio : kFocalRatios) {
    std::vector<RawCamera> lenses;
    for (const CameraInput& camera : views.cameras) lenses.push_back(first_guess(camera, model, ratio));
    auto rig = estimate_geometry(trial, lenses);
    if (!rig) continue;
    const double cost = improve(observations, *rig);
    if (cost < least && is_plausible(*rig)) least = cost, best = rig;
  }
  if (!best) {
    throw InputError("no camera model fits these corners at all: is the target file the board that was shown?");
  }
  return place_boards_of(views, *best);
}

RigEstimate place_boards_of(const BoardViews& views, const RigEstimate& cameras) {
  auto placed = estimate_geometry(views, cameras.cameras);
  if (!placed) throw InputError("a camera never sees the board together with another one");
  placed->T_cam_first = cameras.T_cam_first;
  solve(to_observations(views), *placed, {.fix_cameras = true, .cauchy_px = kRobustPx, .max_iterations = 30});
  return *placed;
}

}  // namespace arpent::calib
