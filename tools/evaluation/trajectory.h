// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Trajectories against the truth: files (TUM, KITTI, EuRoC), association by time, alignment, and the errors of the
// field: ATE, RPE, KITTI segments.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/geometry.h"
#include "common/time.h"

namespace arpent::evaluation {

struct StampedPose {
  Time stamp;
  Pose T_ref_body = Pose::Identity();  ///< the moving frame in the reference frame
};
using Trajectory = std::vector<StampedPose>;

/// Reads TUM (`t x y z qx qy qz qw`), EuRoC (`ns, x, y, z, qw, qx, qy, qz, …`) or KITTI (12 numbers a line; stamped at
/// 10 Hz from zero, as the format has no times), told apart by the number of columns and commas. Throws InputError with
/// file and line.
[[nodiscard]] Trajectory read_trajectory(const std::filesystem::path& file);
/// TUM, microseconds, 9 decimals; all of the file or nothing.
void write_tum(const std::filesystem::path& file, const Trajectory& trajectory);

/// Pairs of poses of equal time: each estimate with the nearest reference within `max_difference`, one to one, in time
/// order.
struct Associated {
  std::vector<StampedPose> reference;
  std::vector<StampedPose> estimate;
};
[[nodiscard]] Associated associate(const Trajectory& reference, const Trajectory& estimate,
                                   Duration max_difference = std::chrono::milliseconds(10));

enum class Alignment { kNone, kSe3, kPosYaw };
/// The motion of the estimate's reference frame that brings its positions closest to the reference's in the
/// least-squares sense (Umeyama 1991 without scale; kPosYaw turns about z only). Identity for kNone.
[[nodiscard]] Pose align(const Associated& pairs, Alignment alignment);

struct Statistics {
  double rmse = 0, mean = 0, median = 0, std = 0, min = 0, max = 0;
};
[[nodiscard]] Statistics statistics(std::vector<double> errors);

struct SegmentError {
  double t_rel_percent = 0;    ///< mean |translation error| / length
  double r_rel_deg_per_m = 0;  ///< mean rotation error / length
  int segments = 0;
};

struct TrajectoryErrors {
  int poses = 0;            ///< associated pairs
  double path_m = 0;        ///< of the reference
  Statistics ate_m;         ///< after alignment
  Statistics rotation_deg;  ///< after alignment
  Statistics rpe_m;         ///< per pair of following poses
  Statistics rpe_deg;
  double end_error_percent = 0;  ///< error of the last pose with the first ones laid upon each other, of the path
  SegmentError segments;
  std::vector<double> segment_lengths_m;
  std::vector<StampedPose> aligned;  ///< the estimate in the reference's frame
  std::vector<double> error_m;       ///< per pose
};

/// `segment_lengths_m` empty: KITTI's 100 to 800 m, or 10 to 40 m if the path is shorter than 100 m.
[[nodiscard]] TrajectoryErrors evaluate(const Trajectory& reference, const Trajectory& estimate, Alignment alignment,
                                        std::vector<double> segment_lengths_m = {});

}  // namespace arpent::evaluation
