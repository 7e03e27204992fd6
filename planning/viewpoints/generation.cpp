// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/generation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace arpent::planning {
namespace {

using mapping::IncompleteElement;
using std::numbers::pi;

/// Viewpoints that became one.
struct Group {
  Eigen::Vector2d position_sum = Eigen::Vector2d::Zero();
  Eigen::Vector2d heading_sum = Eigen::Vector2d::Zero();
  int count = 0;
  Viewpoint merged;
};

Eigen::Vector2d heading(const Pose2& pose) {
  return {std::cos(pose.yaw_rad), std::sin(pose.yaw_rad)};
}

Pose2 mean_of(const Group& group, const Viewpoint& more) {
  const Eigen::Vector2d position = (group.position_sum + more.pose.position_m()) / (group.count + 1);
  const Eigen::Vector2d along = group.heading_sum + heading(more.pose);
  return {position.x(), position.y(), std::atan2(along.y(), along.x())};
}

void add(Group& group, const Viewpoint& more, const Pose2& mean) {
  group.position_sum += more.pose.position_m();
  group.heading_sum += heading(more.pose);
  ++group.count;
  group.merged.pose = mean;
  group.merged.elements.insert(group.merged.elements.end(), more.elements.begin(), more.elements.end());
}

/// Groups by the square of edge `cell_m` in which their mean stands.
class GroupIndex {
 public:
  explicit GroupIndex(double cell_m) : cell_m_(cell_m) {}
  void insert(std::size_t group, const Pose2& at) { cells_[cell(at)].push_back(group); }
  void erase(std::size_t group, const Pose2& at) { std::erase(cells_[cell(at)], group); }
  /// Those that may be within a cell's edge, ascending.
  [[nodiscard]] std::vector<std::size_t> near(const Pose2& at) const {
    std::vector<std::size_t> found;
    const auto [x, y] = cell(at);
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto here = cells_.find({x + dx, y + dy});
        if (here != cells_.end()) found.insert(found.end(), here->second.begin(), here->second.end());
      }
    }
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  [[nodiscard]] std::pair<int, int> cell(const Pose2& at) const {
    return {static_cast<int>(std::floor(at.x_m / cell_m_)), static_cast<int>(std::floor(at.y_m / cell_m_))};
  }
  double cell_m_;
  std::map<std::pair<int, int>, std::vector<std::size_t>> cells_;
};

}  // namespace

double stand_off_m(const LevelCamera& camera, double delta_pose_m, double z_m) {
  return std::max(delta_pose_m, camera.stand_off_for_height_m(z_m - camera.p_body_m.z()));
}

Pose2 look_at(const LevelCamera& camera, const Eigen::Vector3d& p_map_m, double azimuth_rad, double stand_off_m) {
  const Eigen::Vector2d centre =
      p_map_m.head<2>() + stand_off_m * Eigen::Vector2d(std::cos(azimuth_rad), std::sin(azimuth_rad));
  return camera.body_at(centre, azimuth_rad + pi);
}

std::vector<double> azimuths_around(const IncompleteElement& element, int count) {
  const double first = std::atan2(element.direction.y(), element.direction.x());
  std::vector<double> azimuths{first};
  for (int i = 1; i < count; ++i) {
    const int turn = i % 2 == 1 ? (i + 1) / 2 : -i / 2;  // +1, -1, +2, -2, …
    azimuths.push_back(wrap_angle(first + 2 * pi * turn / count));
  }
  return azimuths;
}

bool is_steep(const IncompleteElement& element, double steep_angle_deg) {
  return std::abs(element.direction.z()) > std::cos(steep_angle_deg * pi / 180);
}

std::vector<Viewpoint> generate_viewpoints(std::span<const IncompleteElement> elements, const LevelCamera& camera,
                                           const ViewpointParams& params, const FreeSpace& free_space,
                                           const Pose2& robot) {
  std::vector<std::optional<Pose2>> found(elements.size());
  // The k-th azimuth of all elements that have no pose yet, then the next one: questions about reach go in batches.
  for (int k = 0; k < params.ring; ++k) {
    std::vector<Pose2> poses;
    std::vector<std::size_t> asked_for;
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const double distance_m = stand_off_m(camera, params.delta_pose_m, elements[i].centre_m.z());
      if (found[i] || distance_m > camera.max_range_m) continue;
      const double azimuth_rad = azimuths_around(elements[i], params.ring)[static_cast<std::size_t>(k)];
      const Pose2 pose = look_at(camera, elements[i].centre_m, azimuth_rad, distance_m);
      if (!free_space.is_free(pose)) continue;
      poses.push_back(pose);
      asked_for.push_back(i);
    }
    const auto distances_m = free_space.distances_m(robot, poses);
    for (std::size_t j = 0; j < poses.size(); ++j) {
      if (distances_m[j]) found[asked_for[j]] = poses[j];
    }
  }
  std::vector<Viewpoint> viewpoints;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (found[i]) viewpoints.push_back({*found[i], {elements[i].voxel}, 1});
  }
  return viewpoints;
}

std::vector<Viewpoint> merge_viewpoints(std::span<const Viewpoint> viewpoints, double distance_m, double angle_rad,
                                        const FreeSpace& free_space) {
  std::vector<Group> groups;
  GroupIndex index(std::max(distance_m, 1e-3));
  const auto joins = [&](const Viewpoint& viewpoint, Group& group, std::size_t g) {
    if ((group.merged.pose.position_m() - viewpoint.pose.position_m()).norm() >= distance_m) return false;
    if (heading(group.merged.pose).dot(heading(viewpoint.pose)) < std::cos(angle_rad)) return false;
    const Pose2 mean = mean_of(group, viewpoint);
    if (!free_space.is_free(mean)) return false;
    index.erase(g, group.merged.pose);
    add(group, viewpoint, mean);
    index.insert(g, mean);
    return true;
  };
  for (const Viewpoint& viewpoint : viewpoints) {
    const auto near = index.near(viewpoint.pose);
    if (std::any_of(near.begin(), near.end(), [&](std::size_t g) { return joins(viewpoint, groups[g], g); })) continue;
    groups.emplace_back();
    add(groups.back(), viewpoint, viewpoint.pose);
    index.insert(groups.size() - 1, viewpoint.pose);
  }
  std::vector<Viewpoint> merged;
  for (Group& group : groups) {
    std::sort(group.merged.elements.begin(), group.merged.elements.end(), mapping::before);
    merged.push_back(std::move(group.merged));
  }
  return merged;
}

}  // namespace arpent::planning
