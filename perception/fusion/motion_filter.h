// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The error-state Kalman filter under the fused pose. It predicts the body with wheels and gyro and corrects with the
// motion that visual odometry measured since the pair before, against a clone of the pose at that pair (stochastic
// cloning: Roumeliotis and Burdick, "Stochastic cloning", ICRA 2002). Beside the pose it estimates the gyro's bias and
// the scales of the wheels. It decides what is slip, what is a jump of the odometry, and when the base stands. It knows
// the order of events only from its caller (pose_fusion.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/geometry.h"
#include "common/time.h"
#include "common/twist2.h"
#include "perception/fusion/params.h"

namespace arpent::fusion {

enum class Frame : std::int8_t { kOdom, kWorld };

/// Order of the error state. Pose errors are `local(estimate, truth)`: (translation [m], rotation [rad]) in body axes.
enum StateIndex { kPose = 0, kGyroBias = 6, kDistanceScale = 7, kTurnScale = 8, kClone = 9, kStates = 15 };
using StateCovariance = Eigen::Matrix<double, kStates, kStates>;
/// Without the clone.
using MotionCovariance = Eigen::Matrix<double, kClone, kClone>;

/// What wheels and gyro say about one interval of time.
struct Interval {
  struct Wheels {
    double distance_m = 0;  ///< mean way of both sides
    double turn_rad = 0;    ///< from their difference
    bool still = false;     ///< unmoved for a while, and told to stand
  };
  double duration_s = 0;
  std::optional<Wheels> wheels;    ///< absent: unheard or at fault
  std::optional<double> gyro_rad;  ///< integral of the yaw rate; absent: no reading
};

/// One message of visual odometry.
struct OdometryReading {
  Time stamp;
  std::int64_t sequence = 0;
  Pose T_odom_body = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();       ///< accumulated, body axes
  Matrix6d step_covariance = Matrix6d::Zero();  ///< of the motion since the last pair, body axes
  bool usable = false;                          ///< OK or DEGRADED
  bool anchored = false;    ///< the next pair's motion counts from here: usable, or lost and started anew at this pair
  std::string reason = {};  ///< why not OK
};

/// Motion since some moment and its covariance, from prediction alone.
struct Drift {
  Pose T_then_now = Pose::Identity();
  MotionCovariance covariance = MotionCovariance::Zero();
};

struct FilterState {
  Time stamp{};
  Frame frame = Frame::kOdom;
  Pose T_frame_body = Pose::Identity();
  double gyro_bias_radps = 0;
  double distance_scale = 0;  ///< true way = (1 + scale) * odometers' way
  double turn_scale = 0;
  StateCovariance P = StateCovariance::Zero();
  Twist2 twist;

  /// The pair that the next motion counts from.
  struct Clone {
    Time stamp;
    std::int64_t sequence = 0;
    Pose T_frame_body;  ///< estimate
    Pose T_odom_body;   ///< as visual odometry has it
  };
  std::optional<Clone> clone;
  Drift since_clone;     ///< from wheels (even if they slip) and gyro
  Drift since_odometry;  ///< as predicted since the last odometry that was used
  bool wheels_since_clone = true, gyro_since_clone = true, still_since_clone = true;

  bool started = false;  ///< visual odometry has been seen
  bool slipping = false;
  std::optional<Time> odometry_stamp;  ///< newest that was used
  Twist2 odometry_twist;               ///< mean over its step
  std::string odometry_fault;          ///< why the newest was not used, empty if it was

  std::optional<Pose> T_world_last_tag;          ///< where the robot was at the last tag that counted
  std::optional<Pose> T_world_odom_suspect;      ///< an alignment that contradicts the pose, waiting for a second one
  std::int64_t slips = 0, refused_odometry = 0;  ///< counts since the start
  std::int64_t used_tags = 0, refused_tags = 0;
  std::int64_t refused_alignments = 0;
};

/// An absolute measurement of the body in the world.
struct WorldReading {
  Time stamp;
  Pose T_world_body = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< body axes
};

/// The odometry frame in the world.
struct AlignmentReading {
  Time stamp;
  Pose T_world_odom = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< axes of odom
};

/// All functions leave the state's stamp to the interval; measurements are of that moment.
class MotionFilter {
 public:
  explicit MotionFilter(const FusionParams& params) : params_(params) {}

  [[nodiscard]] FilterState initial(Time stamp) const;
  void predict(FilterState& state, const Interval& interval) const;
  void correct(FilterState& state, const OdometryReading& reading) const;
  /// The first one moves the pose into the world; a later one that agrees changes nothing while tags are used, and
  /// corrects if they are not; two that contradict the pose and agree with each other set it anew.
  void correct(FilterState& state, const AlignmentReading& reading) const;
  void correct(FilterState& state, const WorldReading& tag) const;
  /// The motion during a gap of the time base is unknown.
  void leap(FilterState& state, Time to) const;

 private:
  [[nodiscard]] bool stands(const FilterState& state, const Interval& interval) const;
  void learn_bias(FilterState& state, const Interval& interval) const;
  [[nodiscard]] std::string find_jump(const FilterState& state, const OdometryReading& reading,
                                      const Vector6d& motion) const;
  void use_motion(FilterState& state, const OdometryReading& reading) const;
  void start(FilterState& state, const OdometryReading& reading) const;
  void set_clone(FilterState& state, const OdometryReading& reading) const;

  FusionParams params_;
};

}  // namespace arpent::fusion
