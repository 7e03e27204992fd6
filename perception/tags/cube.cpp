// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/cube.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "common/config/config.h"
#include "common/error.h"

namespace arpent::tags {
namespace {

using Eigen::Vector3d;

TagCorners corners_of_face(const TagCubeConfig& config, int face) {
  const double heading_rad = config.yaw_rad + face * M_PI / 2;
  const Vector3d outward(std::cos(heading_rad), std::sin(heading_rad), 0);
  const Vector3d up = Vector3d::UnitZ();
  const Vector3d right = up.cross(outward);  // of one who looks at the face
  const Vector3d middle = Vector3d(config.x_m, config.y_m, config.z_m) + 0.5 * config.edge_m * outward;
  const double half_m = 0.5 * config.tag_m;
  return {middle + half_m * (-right - up), middle + half_m * (right - up), middle + half_m * (right + up),
          middle + half_m * (up - right)};
}

}  // namespace

namespace detail {

config::Rule<std::vector<double>> four_tag_ids() {
  return {"four different whole numbers from 0 to 586", [](const std::vector<double>& ids) {
            const bool valid = std::all_of(
                ids.begin(), ids.end(), [](double id) { return id >= 0 && id < kFamilySize && id == std::floor(id); });
            return valid && ids.size() == 4 && std::set<double>(ids.begin(), ids.end()).size() == 4;
          }};
}

}  // namespace detail

TagCube::TagCube(const TagCubeConfig& config) : tag_m_(config.tag_m) {
  config::check(config, "tag cube");
  if (config.tag_m > config.edge_m) throw InputError("tag cube: tag_m must be <= edge_m: a tag does not fit its face");
  for (int face = 0; face < 4; ++face) {
    const auto k = static_cast<std::size_t>(face);
    ids_[k] = static_cast<int>(config.ids[k]);
    corners_world_m_[k] = corners_of_face(config, face);
  }
}

const TagCorners* TagCube::find_corners(int id) const {
  const auto found = std::find(ids_.begin(), ids_.end(), id);
  return found == ids_.end() ? nullptr : &corners_world_m_[static_cast<std::size_t>(found - ids_.begin())];
}

}  // namespace arpent::tags
