// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The fused pose of the body, from wheels, gyro, visual odometry, and (once the odometry frame is aligned) tags. It
// keeps the last two seconds of inputs and states. Whatever comes is put at its measurement time and everything after
// is computed again, so that the estimate depends on what has come, never on the order in which it came.
//
// What is dropped, by utime alone: a reading not after the last one of its own stream; one more than two seconds
// behind the newest input; one more than two seconds ahead of it, unless the next of its stream (wheels or odometry)
// follows it: then the time base has leapt, and everything goes on from there.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "perception/fusion/motion_filter.h"

namespace arpent::fusion {

struct WheelReading {
  Time stamp;
  double left_m = 0;  ///< way of the left side since whenever, without jumps
  double right_m = 0;
  Twist2 commanded = {};
  bool usable = true;  ///< false: the base is unheard or its odometers are at fault
};

struct GyroReading {
  Time stamp;
  double yaw_rate_radps = 0;  ///< about body z
};

enum class Status : std::int8_t { kOk = 0, kDeadReckoning = 1, kLost = 2 };

struct FusedPose {
  Time stamp;
  Frame frame = Frame::kOdom;
  Pose T_frame_body = Pose::Identity();
  Twist2 twist;                            ///< in body axes
  Matrix6d covariance = Matrix6d::Zero();  ///< (translation [m], rotation [rad]) in body axes
  Status status = Status::kLost;
  std::string reason;                  ///< why not OK
  std::optional<Time> odometry_stamp;  ///< of the newest visual odometry in it
};

class PoseFusion {
 public:
  /// Throws InputError for parameters that break their rules.
  explicit PoseFusion(const FusionParams& params);

  /// Takes a reading. Returns why it was dropped, empty if it was not.
  [[nodiscard]] std::string add(const WheelReading& reading);
  [[nodiscard]] std::string add(const GyroReading& reading);
  [[nodiscard]] std::string add(const OdometryReading& reading);
  [[nodiscard]] std::string add(const WorldReading& tag);
  [[nodiscard]] std::string add(const AlignmentReading& reading);

  /// The best estimate of the pose at a time within the last two seconds or shortly ahead, from all inputs of up to
  /// that time (and what interpolates them). Nullopt before the first input, and outside of what is kept.
  [[nodiscard]] std::optional<FusedPose> at(Time stamp);
  /// The filter's state at the newest input: biases, scales, counts. Nullopt before the first input.
  [[nodiscard]] std::optional<FilterState> newest_state();
  /// Time of the newest input of any kind.
  [[nodiscard]] std::optional<Time> newest() const { return newest_; }

 private:
  struct WheelSample {
    WheelReading reading;
    bool still = false;
  };
  struct Node {
    std::optional<OdometryReading> odometry;
    std::optional<AlignmentReading> alignment;
    std::optional<WorldReading> tag;
    std::optional<FilterState> after;  ///< absent until computed
  };
  struct Stream {
    std::optional<Time> last;
    std::optional<Time> suspect;
  };

  [[nodiscard]] std::string admit(Stream& stream, Time stamp, bool leads);
  void restart(Time stamp);
  void begin(Time stamp);
  void forget_states(Time from);
  void forget_old();
  [[nodiscard]] bool is_still(const WheelReading& reading) const;
  [[nodiscard]] FilterState state_at(Time stamp);
  void advance(FilterState& state, Time to) const;
  [[nodiscard]] std::optional<Interval::Wheels> wheels_between(Time from, Time to) const;
  [[nodiscard]] std::optional<double> gyro_rate_at(Time stamp) const;
  [[nodiscard]] std::optional<double> gyro_between(Time from, Time to) const;
  [[nodiscard]] FusedPose to_pose(const FilterState& state) const;

  FusionParams params_;
  MotionFilter filter_;
  std::optional<FilterState> base_;  ///< before all nodes
  std::map<Time, Node> nodes_;
  std::map<Time, WheelSample> wheels_;
  std::map<Time, double> gyro_;
  std::optional<Time> newest_;
  Stream wheel_stream_, gyro_stream_, odometry_stream_, tag_stream_;
};

}  // namespace arpent::fusion
