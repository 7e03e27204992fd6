// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Viewpoints as the thesis generates them (Sect. 2.4.2), for a robot on the ground: one per element, in the direction
// from which it wants to be seen, then merged. Preset `thesis`.
#pragma once

#include <span>
#include <vector>

#include "mapping/surface/incomplete_surface.h"
#include "planning/viewpoints/free_space.h"
#include "planning/viewpoints/level_camera.h"
#include "planning/viewpoints/viewpoint.h"

namespace arpent::planning {

/// Distance on the ground from which a point is looked at: max(delta_pose, |z_v - z_cam| / tan(FOV_V / 2)), the second
/// so that it is inside the vertical view of a camera that cannot tilt.
[[nodiscard]] double stand_off_m(const LevelCamera& camera, double delta_pose_m, double z_m);

/// The body's pose from which the middle of the pair, `stand_off_m` away in direction `azimuth_rad`, looks at the
/// point.
[[nodiscard]] Pose2 look_at(const LevelCamera& camera, const Eigen::Vector3d& p_map_m, double azimuth_rad,
                            double stand_off_m);

/// The azimuth from which the element wants to be seen, then `count` - 1 others around it, the nearest first.
[[nodiscard]] std::vector<double> azimuths_around(const mapping::IncompleteElement& element, int count);

/// True if the direction is so near to the vertical that its azimuth says little.
[[nodiscard]] bool is_steep(const mapping::IncompleteElement& element, double steep_angle_deg);

/// One viewpoint per element: at its own azimuth or, where that is not free or cannot be reached from `robot`, at the
/// first of the ring that is. No viewpoint for elements without such a pose, or beyond the range of depth. In the
/// elements' order.
[[nodiscard]] std::vector<Viewpoint> generate_viewpoints(std::span<const mapping::IncompleteElement> elements,
                                                         const LevelCamera& camera, const ViewpointParams& params,
                                                         const FreeSpace& free_space, const Pose2& robot);

/// Merges viewpoints nearer than `distance_m` whose headings differ by at most `angle_rad` (their signed product is at
/// least its cosine) into one at their mean position and heading, first come first served, as long as the mean is free.
/// The merged viewpoint keeps all elements.
[[nodiscard]] std::vector<Viewpoint> merge_viewpoints(std::span<const Viewpoint> viewpoints, double distance_m,
                                                      double angle_rad, const FreeSpace& free_space);

}  // namespace arpent::planning
