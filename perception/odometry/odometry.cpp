// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/odometry/odometry.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

#include "common/config/config.h"
#include "common/error.h"
#include "perception/odometry/pose_solver.h"
#include "perception/odometry/tracker.h"
#include "perception/odometry/window.h"

namespace arpent::odometry {
namespace {

constexpr double kPixelSigmaPx = 0.25;
constexpr int kCellPx = 48;
constexpr int kMinPoints = 12;
constexpr int kDegradedPoints = 30;
constexpr double kMinInlierShare = 0.3;
constexpr double kKeyframeShare = 0.6;    // eVO's rule: a new keyframe when the tracks run low
constexpr double kKeyframeMotionPx = 60;  // and before appearance has changed too much
/// While points have moved less than this since the keyframe they are followed from the keyframe itself: errors then do
/// not add up at rest.
constexpr double kFromKeyframePx = 24;
constexpr std::size_t kWindowKeyframes = 6;
constexpr int kMinSpreadCells = 6;
/// What is believed of the disparity offset at first, and how much it may change from keyframe to keyframe [px].
constexpr double kOffsetSigmaPx = 0.1;
constexpr double kOffsetWalkPx = 0.002;

/// A point that is followed, or that was and still ties keyframes of the window together.
struct Track {
  cv::Point2f px;           ///< in the last left image
  cv::Point2f keyframe_px;  ///< in the last keyframe's left image
  Vector3d p_odom_m;
  Matrix3d covariance_m2;
  std::vector<std::pair<int, Observation>> seen;  ///< by keyframe number
  bool alive = true;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Matrix6d adjoint_of_inverse(const Pose& T_a_b) {
  const Pose T = T_a_b.inverse();
  const Vector3d t = T.translation();
  Matrix3d skew;
  skew << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  Matrix6d Ad = Matrix6d::Zero();
  Ad.topLeftCorner<3, 3>() = T.linear();
  Ad.bottomRightCorner<3, 3>() = T.linear();
  Ad.topRightCorner<3, 3>() = skew * T.linear();
  return Ad;
}

}  // namespace

struct StereoOdometry::State {
  RectifiedStereo stereo;
  OdometryParams params;
  std::vector<Track> tracks;
  std::deque<std::pair<int, Pose>> keyframes;  ///< number and T_odom_cam, oldest first
  int next_keyframe = 0;
  std::size_t keyframe_points = 0;
  Pyramid keyframe_left, last_left;
  Pose T_odom_cam = Pose::Identity();
  Pose T_last_now = Pose::Identity();  ///< the last step, for prediction
  Matrix6d keyframe_covariance = Matrix6d::Zero();
  std::uint64_t pairs = 0;
  DisparityOffset offset{0, kOffsetSigmaPx* kOffsetSigmaPx};

  /// What one pair gave: measurements and the tracks they belong to.
  struct Measured {
    std::vector<PointMeasurement> measurements;
    std::vector<std::size_t> track;
    PoseSolution solution;
  };

  [[nodiscard]] int max_disparity_px() const { return std::min(400, stereo.camera.width_px / 2); }

  [[nodiscard]] std::vector<cv::Point2f> predict(const Pose& T_guess) const {
    const Pose T_cam_odom = T_guess.inverse();
    std::vector<cv::Point2f> guess;
    for (const Track& track : tracks) {
      if (!track.alive) continue;
      const Vector3d p = T_cam_odom * track.p_odom_m;
      if (p.z() < 0.1) {
        guess.push_back(track.px);
        continue;
      }
      const Vector3d z = project(stereo, p);
      guess.emplace_back(static_cast<float>(z.x()), static_cast<float>(z.y()));
    }
    return guess;
  }

  [[nodiscard]] double motion_since_keyframe_px(const std::vector<cv::Point2f>& now) const {
    std::vector<double> moved;
    std::size_t i = 0;
    for (const Track& track : tracks) {
      if (track.alive) moved.push_back(cv::norm(now[i++] - track.keyframe_px));
    }
    return median(std::move(moved));
  }

  /// The rotation that best explains how the whole image has shifted since the last pair: what helps when the robot
  /// begins to turn and points move farther than Lucas-Kanade can follow.
  [[nodiscard]] Pose turn_since_last(const Pyramid& left) const {
    const cv::Point2d shift_px = measure_shift(last_left.image, left.image);
    const double yaw_rad = -std::atan2(shift_px.x, stereo.camera.fx_px);
    const double pitch_rad = std::atan2(shift_px.y, stereo.camera.fy_px);
    Pose turn = Pose::Identity();
    turn.linear() = so3_exp({pitch_rad, yaw_rad, 0});
    return turn;
  }

  /// Follows all live tracks into the new pair, starting where `T_guess` predicts them, and solves for the pose.
  Measured measure(const Pyramid& left, const Pyramid& right, const Pose& T_guess, bool predicted) const {
    std::vector<cv::Point2f> from;
    std::vector<cv::Point2f> guess = predict(T_guess);
    const bool from_keyframe = predicted && motion_since_keyframe_px(guess) < kFromKeyframePx;
    std::vector<std::size_t> live;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      if (!tracks[i].alive) continue;
      from.push_back(from_keyframe ? tracks[i].keyframe_px : tracks[i].px);
      if (!predicted) guess[live.size()] = tracks[i].px;
      live.push_back(i);
    }
    const auto found = track_points(from_keyframe ? keyframe_left : last_left, left, from, guess);
    return solve(left, right, T_guess, live, found);
  }

  Measured solve(const Pyramid& left, const Pyramid& right, const Pose& T_guess, const std::vector<std::size_t>& live,
                 const std::vector<std::optional<cv::Point2f>>& found) const {
    Measured measured;
    std::vector<cv::Point2f> left_px;
    std::vector<cv::Point2f> right_guess;
    for (std::size_t k = 0; k < live.size(); ++k) {
      if (!found[k]) continue;
      const Track& track = tracks[live[k]];
      const double depth_m = std::max(0.1, (T_guess.inverse() * track.p_odom_m).z());
      left_px.push_back(*found[k]);
      right_guess.emplace_back(
          found[k]->x - static_cast<float>(stereo.baseline_m * stereo.camera.fx_px / depth_m - offset.px), found[k]->y);
      measured.track.push_back(live[k]);
    }
    const auto right_u = refine_right(left, right, left_px, right_guess);
    for (std::size_t k = 0; k < left_px.size(); ++k) {
      const Track& track = tracks[measured.track[k]];
      measured.measurements.push_back({track.p_odom_m, track.covariance_m2,
                                       Vector3d(left_px[k].x, left_px[k].y, right_u[k].value_or(0.0F) - offset.px),
                                       right_u[k].has_value()});
    }
    measured.solution =
        solve_pose(stereo, measured.measurements, T_guess, static_cast<std::uint64_t>(params.seed) * 1000003U + pairs,
                   {.pixel_sigma_px = kPixelSigmaPx});
    return measured;
  }

  [[nodiscard]] static bool good(const Measured& measured) {
    return measured.solution.inliers >= kMinPoints &&
           measured.solution.inliers >= kMinInlierShare * static_cast<double>(measured.measurements.size());
  }

  [[nodiscard]] int cells_covered(const Measured& measured) const {
    std::vector<std::pair<int, int>> cells;
    for (std::size_t k = 0; k < measured.measurements.size(); ++k) {
      if (!measured.solution.inlier[k]) continue;
      const Vector3d& z = measured.measurements[k].z_px;
      cells.emplace_back(static_cast<int>(z.x() * 8 / stereo.camera.width_px),
                         static_cast<int>(z.y() * 6 / stereo.camera.height_px));
    }
    std::sort(cells.begin(), cells.end());
    return static_cast<int>(std::unique(cells.begin(), cells.end()) - cells.begin());
  }

  /// Keeps the inliers alive at their new pixels; returns how many there are.
  void accept(const Measured& measured) {
    std::vector<std::optional<std::size_t>> measurement_of(tracks.size());
    for (std::size_t k = 0; k < measured.track.size(); ++k) {
      if (measured.solution.inlier[k]) measurement_of[measured.track[k]] = k;
    }
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      if (!tracks[i].alive) continue;
      tracks[i].alive = measurement_of[i].has_value();
      if (!tracks[i].alive) continue;
      const Vector3d& z = measured.measurements[*measurement_of[i]].z_px;
      tracks[i].px = {static_cast<float>(z.x()), static_cast<float>(z.y())};
    }
  }

  [[nodiscard]] bool wants_keyframe(const Measured& measured) const {
    std::vector<cv::Point2f> now;
    for (const Track& track : tracks) {
      if (track.alive) now.push_back(track.px);
    }
    return static_cast<double>(measured.solution.inliers) < kKeyframeShare * static_cast<double>(keyframe_points) ||
           motion_since_keyframe_px(now) > kKeyframeMotionPx;
  }

  /// Makes the present pair a keyframe: ties the live tracks to it, refines the window, adds new points.
  void add_keyframe(const Pyramid& left, const Pyramid& right, const Measured* measured) {
    const int number = next_keyframe++;
    keyframes.emplace_back(number, T_odom_cam);
    if (keyframes.size() > kWindowKeyframes) keyframes.pop_front();
    if (measured != nullptr) {
      for (std::size_t k = 0; k < measured->track.size(); ++k) {
        if (!measured->solution.inlier[k]) continue;
        const PointMeasurement& m = measured->measurements[k];
        const Vector3d raw_px = m.z_px + Vector3d(0, 0, offset.px);
        tracks[measured->track[k]].seen.emplace_back(number, Observation{0, raw_px, m.has_right});
      }
      refine_keyframes();
    }
    forget_old_tracks();
    for (Track& track : tracks) track.keyframe_px = track.px;
    add_points(left, right, number);
    keyframe_left = left;
    keyframe_points = static_cast<std::size_t>(
        std::count_if(tracks.begin(), tracks.end(), [](const Track& track) { return track.alive; }));
  }

  void refine_keyframes() {
    const int oldest = keyframes.front().first;
    std::vector<Pose> poses;
    for (const auto& keyframe : keyframes) poses.push_back(keyframe.second);
    std::vector<WindowPoint> points;
    std::vector<Track*> owners;
    for (Track& track : tracks) {
      WindowPoint point{track.p_odom_m, track.covariance_m2, {}};
      for (const auto& [number, observation] : track.seen) {
        if (number >= oldest) point.observations.push_back({number - oldest, observation.z_px, observation.has_right});
      }
      if (point.observations.size() < 2) continue;
      points.push_back(std::move(point));
      owners.push_back(&track);
    }
    offset.variance_px2 += kOffsetWalkPx * kOffsetWalkPx;
    refine_window(stereo, kPixelSigmaPx, 1, 1.0 / static_cast<double>(kWindowKeyframes), poses, points, offset);
    for (std::size_t i = 0; i < points.size(); ++i) {
      owners[i]->p_odom_m = points[i].p_odom_m;
      owners[i]->covariance_m2 = points[i].covariance_m2;
    }
    for (std::size_t i = 0; i < poses.size(); ++i) keyframes[i].second = poses[i];
    T_odom_cam = poses.back();
  }

  void forget_old_tracks() {
    const int oldest = keyframes.front().first;
    std::erase_if(tracks, [&](const Track& track) {
      return !track.alive && (track.seen.size() < 2 || track.seen.back().first <= oldest);
    });
  }

  void add_points(const Pyramid& left, const Pyramid& right, int number) {
    std::vector<cv::Point2f> taken;
    for (const Track& track : tracks) {
      if (track.alive) taken.push_back(track.px);
    }
    const auto corners = find_corners(left, taken, kCellPx, 2);
    const auto right_u = match_right(left, right, corners, max_disparity_px());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (!right_u[i]) continue;
      const Vector3d z(corners[i].x, corners[i].y, *right_u[i]);
      const Vector3d p_cam = triangulate(stereo, z - Vector3d(0, 0, offset.px));
      const Matrix3d J = T_odom_cam.linear() * project_jacobian(stereo, p_cam).inverse();
      Track track{corners[i], corners[i], T_odom_cam * p_cam, kPixelSigmaPx * kPixelSigmaPx * J * J.transpose(), {}};
      track.seen.emplace_back(number, Observation{0, z, true});
      tracks.push_back(std::move(track));
    }
  }

  /// Starts anew from the present pose: after the first pair and after a loss. The next step is expected to be like the
  /// last one that is known: what was lost in a turn is mostly still turning.
  void restart(const Pyramid& left, const Pyramid& right) {
    tracks.clear();
    keyframes.clear();
    add_keyframe(left, right, nullptr);
  }

  Estimate first(Time stamp, const Pyramid& left, const Pyramid& right, const std::string& lost_reason);
  Estimate next(Time stamp, const Pyramid& left, const Pyramid& right, const std::optional<Pose>& expected);
  Measured follow(const Pyramid& left, const Pyramid& right, const std::optional<Pose>& expected) const;
};

Estimate StereoOdometry::State::first(Time stamp, const Pyramid& left, const Pyramid& right,
                                      const std::string& lost_reason) {
  restart(left, right);
  last_left = left;
  Estimate estimate;
  estimate.stamp = stamp;
  estimate.T_odom_cam = T_odom_cam;
  estimate.covariance = keyframe_covariance;
  estimate.keyframe = true;
  const bool enough = keyframe_points >= static_cast<std::size_t>(kMinPoints);
  estimate.status = enough && lost_reason.empty() ? Status::kOk : Status::kLost;
  estimate.reason = !lost_reason.empty() ? lost_reason : enough ? "" : "too few textured points in view";
  estimate.inliers = static_cast<int>(keyframe_points);
  if (!enough) tracks.clear();
  return estimate;
}

/// Looks for the points where wheels and gyro, or else the last step, predict them; failing that, where the shift of
/// the whole image does, or where they were.
StereoOdometry::State::Measured StereoOdometry::State::follow(const Pyramid& left, const Pyramid& right,
                                                              const std::optional<Pose>& expected) const {
  Measured measured;
  if (expected) {
    measured = measure(left, right, T_odom_cam * *expected, true);
    if (good(measured)) return measured;
  }
  measured = measure(left, right, T_odom_cam * T_last_now, true);
  if (!good(measured)) measured = measure(left, right, T_odom_cam * turn_since_last(left), true);
  if (!good(measured)) measured = measure(left, right, T_odom_cam, false);
  return measured;
}

Estimate StereoOdometry::State::next(Time stamp, const Pyramid& left, const Pyramid& right,
                                     const std::optional<Pose>& expected) {
  const Measured measured = follow(left, right, expected);
  if (!good(measured)) {
    keyframe_covariance += Matrix6d::Identity();  // the motion across this gap is unknown
    return first(stamp, left, right, "too few points agree on a motion");
  }
  const Pose T_before = T_odom_cam;
  T_odom_cam = measured.solution.T_odom_cam;
  accept(measured);
  Estimate estimate;
  const Matrix6d Ad = adjoint_of_inverse(keyframes.back().second.inverse() * T_odom_cam);
  estimate.step_covariance = measured.solution.covariance;
  estimate.covariance = Ad * keyframe_covariance * Ad.transpose() + measured.solution.covariance;
  estimate.keyframe = wants_keyframe(measured);
  if (estimate.keyframe) {
    keyframe_covariance = estimate.covariance;
    add_keyframe(left, right, &measured);
  }
  T_last_now = T_before.inverse() * T_odom_cam;
  last_left = left;
  estimate.stamp = stamp;
  estimate.T_odom_cam = T_odom_cam;
  estimate.tracked = static_cast<int>(measured.measurements.size());
  estimate.inliers = measured.solution.inliers;
  estimate.status = Status::kOk;
  if (estimate.inliers < kDegradedPoints || cells_covered(measured) < kMinSpreadCells) {
    estimate.status = Status::kDegraded;
    estimate.reason = estimate.inliers < kDegradedPoints ? "few points" : "points cover little of the image";
  }
  return estimate;
}

StereoOdometry::StereoOdometry(const RectifiedStereo& stereo, const OdometryParams& params)
    : state_(std::make_unique<State>()) {
  config::check(params, "odometry");
  const auto faults = find_faults(stereo);
  if (!faults.empty()) throw InputError("odometry: " + faults.front());
  state_->stereo = stereo;
  state_->params = params;
}

StereoOdometry::~StereoOdometry() = default;
StereoOdometry::StereoOdometry(StereoOdometry&&) noexcept = default;
StereoOdometry& StereoOdometry::operator=(StereoOdometry&&) noexcept = default;

DisparityOffset StereoOdometry::disparity_offset() const {
  return state_->offset;
}

Estimate StereoOdometry::track(Time stamp, const cv::Mat1b& left, const cv::Mat1b& right,
                               const std::optional<Pose>& T_last_now) {
  State& state = *state_;
  const PinholeCamera& camera = state.stereo.camera;
  const cv::Size size(camera.width_px, camera.height_px);
  if (left.size() != size || right.size() != size) {
    Estimate estimate;
    estimate.stamp = stamp;
    estimate.T_odom_cam = state.T_odom_cam;
    estimate.covariance = state.keyframe_covariance;
    estimate.reason = "the images are not of the camera's size";
    return estimate;
  }
  ++state.pairs;
  const Pyramid left_pyramid = make_tracked_pyramid(left.clone());
  const Pyramid right_pyramid = make_pyramid(right.clone());
  return state.tracks.empty() ? state.first(stamp, left_pyramid, right_pyramid, "")
                              : state.next(stamp, left_pyramid, right_pyramid, T_last_now);
}

}  // namespace arpent::odometry
