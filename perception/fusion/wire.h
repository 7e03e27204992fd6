// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages <-> types of the fused pose: wheel_state_t, imu_t, odometry_t, tag_observation_t and frame_alignment_t in,
// body_pose_t out (and in, for whoever uses it).
#pragma once

#include <arpent/body_pose_t.hpp>
#include <arpent/frame_alignment_t.hpp>
#include <arpent/imu_t.hpp>
#include <arpent/odometry_t.hpp>
#include <arpent/tag_observation_t.hpp>
#include <arpent/wheel_state_t.hpp>
#include <cstdint>

#include "common/result.h"
#include "perception/fusion/pose_fusion.h"

namespace arpent::fusion {

/// Each checks finiteness, frames, unit quaternions and covariances (symmetric, not negative), and that nothing is
/// larger than any robot can produce.
[[nodiscard]] Result<WheelReading> from_wire(const wheel_state_t& message);
[[nodiscard]] Result<GyroReading> from_wire(const imu_t& message);
[[nodiscard]] Result<OdometryReading> from_wire(const odometry_t& message);
/// A fault as well if the observation is not accepted by its sender.
[[nodiscard]] Result<WorldReading> from_wire(const tag_observation_t& message);
[[nodiscard]] Result<AlignmentReading> from_wire(const frame_alignment_t& message);

[[nodiscard]] body_pose_t to_wire(const FusedPose& pose, std::int64_t sequence);
[[nodiscard]] Result<FusedPose> from_wire(const body_pose_t& message);

}  // namespace arpent::fusion
