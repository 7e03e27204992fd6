// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What the simulator puts on the wire in place of hardware, and, without images, in place of perception.
#pragma once

#include <arpent/depth_t.hpp>
#include <arpent/frame_alignment_t.hpp>
#include <arpent/imu_t.hpp>
#include <arpent/odometry_t.hpp>
#include <arpent/pose_t.hpp>
#include <arpent/stereo_images_t.hpp>
#include <opencv2/core.hpp>

#include "common/camera.h"
#include "common/pose2.h"
#include "common/time.h"
#include "drivers/camera/frame_source.h"
#include "sim/robot/sim_imu.h"
#include "sim/robot/sim_odometry.h"

namespace arpent::sim {

[[nodiscard]] stereo_images_t to_wire(Time stamp, std::int64_t sequence, const camera::ExposureSetting& exposure,
                                      const cv::Mat1b& left, const cv::Mat1b& right);
[[nodiscard]] imu_t to_wire(Time stamp, std::int64_t sequence, const ImuReading& reading);
/// TRUTH_POSE: the body in world.
[[nodiscard]] pose_t to_wire(Time stamp, const Pose2& pose);
/// Depth and its deviation [m], 0 where missing.
[[nodiscard]] depth_t to_wire(Time stamp, std::int64_t sequence, const PinholeCamera& camera, const cv::Mat1f& depth_m,
                              const cv::Mat1f& sigma_m);
/// `duration_s`: since the step before, for the velocity; 0 for the first.
[[nodiscard]] odometry_t to_wire(Time stamp, std::int64_t sequence, const SimulatedStep& step, const Pose& T_last_now,
                                 double duration_s);
/// The odometry's origin in the world, with equal deviations [m, rad] in all directions.
[[nodiscard]] frame_alignment_t to_wire(Time stamp, const Pose& T_world_odom, double sigma_m, double sigma_rad);

}  // namespace arpent::sim
