// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation/trajectory.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "common/atomic_file.h"
#include "common/error.h"

namespace arpent::evaluation {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

/// The numbers of a line; commas count as blanks. nullopt-like: an empty list if something is no number.
std::vector<double> parse_numbers(std::string line) {
  std::replace(line.begin(), line.end(), ',', ' ');
  std::vector<double> numbers;
  const char* at = line.c_str();
  for (;;) {
    while (std::isspace(static_cast<unsigned char>(*at)) != 0) ++at;
    if (*at == '\0') return numbers;
    char* end = nullptr;
    numbers.push_back(std::strtod(at, &end));
    if (end == at || !std::isfinite(numbers.back())) return {};
    at = end;
  }
}

std::optional<StampedPose> parse_line(const std::string& line, std::size_t index) {
  const std::vector<double> n = parse_numbers(line);
  const auto stamped = [](Time stamp, const std::optional<Pose>& pose) {
    return pose ? std::optional(StampedPose{stamp, *pose}) : std::nullopt;
  };
  const bool euroc = line.find(',') != std::string::npos;
  if (euroc && n.size() >= 8) {
    const std::int64_t nanoseconds = std::atoll(line.c_str());
    return stamped(from_utime(nanoseconds / 1000), make_pose({n[1], n[2], n[3]}, {n[4], n[5], n[6], n[7]}));
  }
  if (n.size() == 8) return stamped(Time(from_seconds(n[0])), make_pose({n[1], n[2], n[3]}, {n[7], n[4], n[5], n[6]}));
  if (n.size() != 12) return std::nullopt;
  Eigen::Matrix3d R;
  R << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
  if (!(R * R.transpose()).isIdentity(1e-3)) return std::nullopt;
  const Time stamp(from_seconds(0.1 * static_cast<double>(index)));
  return stamped(stamp, make_pose({n[3], n[7], n[11]}, Eigen::Quaterniond(R).normalized()));
}

double path_length(const std::vector<StampedPose>& poses) {
  double length = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    length += (poses[i].T_ref_body.translation() - poses[i - 1].T_ref_body.translation()).norm();
  }
  return length;
}

/// The motion from pose i to pose j in both, and how they differ.
Pose difference(const Associated& pairs, std::size_t i, std::size_t j) {
  const Pose reference = pairs.reference[i].T_ref_body.inverse() * pairs.reference[j].T_ref_body;
  const Pose estimate = pairs.estimate[i].T_ref_body.inverse() * pairs.estimate[j].T_ref_body;
  return reference.inverse() * estimate;
}

/// KITTI's segment errors, every frame a start.
SegmentError segment_errors(const Associated& pairs, const std::vector<double>& lengths_m) {
  std::vector<double> along{0};
  for (std::size_t i = 1; i < pairs.reference.size(); ++i) {
    along.push_back(
        along.back() +
        (pairs.reference[i].T_ref_body.translation() - pairs.reference[i - 1].T_ref_body.translation()).norm());
  }
  SegmentError error;
  for (const double length : lengths_m) {
    for (std::size_t i = 0; i < along.size(); ++i) {
      const auto end = std::lower_bound(along.begin(), along.end(), along[i] + length);
      if (end == along.end()) break;
      const Pose d = difference(pairs, i, static_cast<std::size_t>(end - along.begin()));
      error.t_rel_percent += 100.0 * d.translation().norm() / length;
      error.r_rel_deg_per_m += kDegrees * so3_log(d.linear()).norm() / length;
      ++error.segments;
    }
  }
  if (error.segments > 0) {
    error.t_rel_percent /= error.segments;
    error.r_rel_deg_per_m /= error.segments;
  }
  return error;
}

Eigen::Matrix3d best_rotation(const Eigen::Matrix3d& covariance, Alignment alignment) {
  if (alignment == Alignment::kPosYaw) {
    const double yaw = std::atan2(covariance(1, 0) - covariance(0, 1), covariance(0, 0) + covariance(1, 1));
    return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d S = Eigen::Matrix3d::Identity();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) S(2, 2) = -1;
  return svd.matrixU() * S * svd.matrixV().transpose();
}

}  // namespace

Trajectory read_trajectory(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in || std::filesystem::is_directory(file)) throw InputError(file.string() + ": cannot be read");
  Trajectory trajectory;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const auto start = line.find_first_not_of(" \t\r");
    if (start == std::string::npos || line[start] == '#') continue;
    const auto pose = parse_line(line, trajectory.size());
    if (!pose) {
      throw InputError(
          fmt::format("{}:{}: is no pose (TUM: t x y z qx qy qz qw; KITTI: 12 numbers; EuRoC: "
                      "ns,x,y,z,qw,qx,qy,qz)",
                      file.string(), number));
    }
    trajectory.push_back(*pose);
  }
  if (trajectory.empty()) throw InputError(file.string() + ": has no poses");
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  return trajectory;
}

void write_tum(const std::filesystem::path& file, const Trajectory& trajectory) {
  std::string text = "# timestamp tx ty tz qx qy qz qw\n";
  for (const auto& [stamp, T] : trajectory) {
    const Eigen::Quaterniond q = canonical_quaternion(T.linear());
    const std::int64_t utime = to_utime(stamp);
    text += fmt::format("{}.{:06} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", utime / 1000000, utime % 1000000,
                        T.translation().x(), T.translation().y(), T.translation().z(), q.x(), q.y(), q.z(), q.w());
  }
  atomic_write(file, text);
}

Associated associate(const Trajectory& reference, const Trajectory& estimate, Duration max_difference) {
  Associated pairs;
  std::size_t from = 0;
  for (const StampedPose& pose : estimate) {
    std::size_t best = reference.size();
    Duration least = max_difference + Duration(1);
    for (std::size_t i = from; i < reference.size() && reference[i].stamp <= pose.stamp + max_difference; ++i) {
      const Duration apart =
          reference[i].stamp > pose.stamp ? reference[i].stamp - pose.stamp : pose.stamp - reference[i].stamp;
      if (apart >= least) continue;
      least = apart;
      best = i;
    }
    if (best == reference.size()) continue;
    pairs.reference.push_back(reference[best]);
    pairs.estimate.push_back(pose);
    from = best + 1;
  }
  return pairs;
}

Pose align(const Associated& pairs, Alignment alignment) {
  if (alignment == Alignment::kNone || pairs.estimate.empty()) return Pose::Identity();
  Eigen::Vector3d mean_reference = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_estimate = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < pairs.estimate.size(); ++i) {
    mean_reference += pairs.reference[i].T_ref_body.translation();
    mean_estimate += pairs.estimate[i].T_ref_body.translation();
  }
  mean_reference /= static_cast<double>(pairs.estimate.size());
  mean_estimate /= static_cast<double>(pairs.estimate.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < pairs.estimate.size(); ++i) {
    covariance += (pairs.reference[i].T_ref_body.translation() - mean_reference) *
                  (pairs.estimate[i].T_ref_body.translation() - mean_estimate).transpose();
  }
  Pose T = Pose::Identity();
  T.linear() = best_rotation(covariance, alignment);
  T.translation() = mean_reference - T.linear() * mean_estimate;
  return T;
}

Statistics statistics(std::vector<double> errors) {
  Statistics s;
  if (errors.empty()) return s;
  std::sort(errors.begin(), errors.end());
  const auto n = static_cast<double>(errors.size());
  double squares = 0;
  for (const double e : errors) {
    s.mean += e / n;
    squares += e * e / n;
  }
  s.rmse = std::sqrt(squares);
  s.std = std::sqrt(std::max(0.0, squares - s.mean * s.mean));
  s.min = errors.front();
  s.max = errors.back();
  s.median = 0.5 * (errors[(errors.size() - 1) / 2] + errors[errors.size() / 2]);
  return s;
}

TrajectoryErrors evaluate(const Trajectory& reference, const Trajectory& estimate, Alignment alignment,
                          std::vector<double> segment_lengths_m) {
  const Associated pairs = associate(reference, estimate);
  if (pairs.estimate.size() < 2) {
    throw InputError(
        "fewer than two poses of the estimate have a reference pose within 10 ms: are the times of both files the "
        "same?");
  }
  TrajectoryErrors errors;
  errors.poses = static_cast<int>(pairs.estimate.size());
  errors.path_m = path_length(pairs.reference);
  const Pose T = align(pairs, alignment);
  std::vector<double> rotations_deg, steps_m, steps_deg;
  for (std::size_t i = 0; i < pairs.estimate.size(); ++i) {
    const Pose aligned = T * pairs.estimate[i].T_ref_body;
    errors.aligned.push_back({pairs.estimate[i].stamp, aligned});
    const Pose& truth = pairs.reference[i].T_ref_body;
    errors.error_m.push_back((aligned.translation() - truth.translation()).norm());
    rotations_deg.push_back(kDegrees * so3_log(truth.linear().transpose() * aligned.linear()).norm());
    if (i == 0) continue;
    const Pose step = difference(pairs, i - 1, i);
    steps_m.push_back(step.translation().norm());
    steps_deg.push_back(kDegrees * so3_log(step.linear()).norm());
  }
  errors.ate_m = statistics(errors.error_m);
  errors.rotation_deg = statistics(rotations_deg);
  errors.rpe_m = statistics(steps_m);
  errors.rpe_deg = statistics(steps_deg);
  const Pose end = difference(pairs, 0, pairs.estimate.size() - 1);
  errors.end_error_percent = errors.path_m > 0 ? 100.0 * end.translation().norm() / errors.path_m : 0.0;
  if (segment_lengths_m.empty()) {
    segment_lengths_m = errors.path_m < 100 ? std::vector<double>{10, 20, 30, 40}
                                            : std::vector<double>{100, 200, 300, 400, 500, 600, 700, 800};
  }
  errors.segments = segment_errors(pairs, segment_lengths_m);
  errors.segment_lengths_m = std::move(segment_lengths_m);
  return errors;
}

}  // namespace arpent::evaluation
