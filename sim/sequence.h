// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A rendered drive: the stereo camera of a rig carried along a path through a scene, pair by pair, with the true poses.
#pragma once

#include <functional>
#include <vector>

#include "common/time.h"
#include "sim/scene.h"

namespace arpent::sim {

struct DrivePose {
  Time stamp;
  Pose T_world_body = Pose::Identity();
};

/// A smooth drive on the ground in the test arena: around the obstacle at 0.5 m/s, at most 1 rad/s, `rate_hz` poses a
/// second.
[[nodiscard]] std::vector<DrivePose> make_arena_drive(double duration_s, double rate_hz, Time start);

struct RenderedPair {
  DrivePose pose;
  cv::Mat1b left, right;
  cv::Mat1f depth_m;  ///< exact, of the left camera
};

/// Renders one pair of an ideal stereo camera. `number` seeds the noise.
[[nodiscard]] RenderedPair render_pair(const Scene& scene, const RectifiedStereo& stereo, const Pose& T_body_cam,
                                       const DrivePose& pose, std::uint64_t number, const CameraNoise& noise = {});

}  // namespace arpent::sim
