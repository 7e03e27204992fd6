// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Pictures of a world for people: what a robot's cameras see from a pose, and the floor plan.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "common/config/rig.h"
#include "sim/world/world.h"

namespace arpent::tools {

struct WorldPictures {
  cv::Mat1b left, right;
  cv::Mat3b depth;  ///< of the left camera, coloured
  cv::Mat3b top;    ///< floor plan: obstacles, starts, the tag cube, the pose
};

[[nodiscard]] WorldPictures draw_world(const sim::World& world, const Rig& rig, const Pose2& pose);

/// Writes left.png, right.png, depth.png and top.png into a folder, or (a name that ends in .png) one sheet. Throws
/// InputError if it cannot.
void write_pictures(const WorldPictures& pictures, const std::filesystem::path& out);

}  // namespace arpent::tools
