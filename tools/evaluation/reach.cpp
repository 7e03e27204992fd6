// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation/reach.h"

#include <cmath>
#include <numbers>

namespace arpent::evaluation {

Reach::Reach(const sim::World& world, const Pose2& start, const sim::EllipseFootprint& footprint, double step_m,
             int headings)
    : ground_(world),
      region_(world.region),
      footprint_(footprint),
      step_m_(step_m),
      headings_(headings),
      columns_(1 + static_cast<int>((region_.max_m.x() - region_.min_m.x()) / step_m)),
      rows_(1 + static_cast<int>((region_.max_m.y() - region_.min_m.y()) / step_m)) {
  const auto places = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  reached_.resize(places * static_cast<std::size_t>(headings_), 0);
  clearance_m_.resize(places, -1.0F);
  flood(start);
}

Pose2 Reach::pose(const Node& node) const {
  return {region_.min_m.x() + node.column * step_m_, region_.min_m.y() + node.row * step_m_,
          wrap_angle(2 * std::numbers::pi * node.heading / headings_)};
}

bool Reach::in_lattice(const Node& node) const {
  return node.column >= 0 && node.row >= 0 && node.column < columns_ && node.row < rows_;
}

std::size_t Reach::index(const Node& node) const {
  return (static_cast<std::size_t>(node.row) * static_cast<std::size_t>(columns_) +
          static_cast<std::size_t>(node.column)) *
             static_cast<std::size_t>(headings_) +
         static_cast<std::size_t>(node.heading);
}

Reach::Node Reach::nearest(const Pose2& body) const {
  const int heading = static_cast<int>(std::lround(body.yaw_rad / (2 * std::numbers::pi) * headings_));
  return {static_cast<int>(std::lround((body.x_m - region_.min_m.x()) / step_m_)),
          static_cast<int>(std::lround((body.y_m - region_.min_m.y()) / step_m_)),
          (heading % headings_ + headings_) % headings_};
}

bool Reach::is_free(const Node& node) {
  float& clearance_m = clearance_m_[index(node) / static_cast<std::size_t>(headings_)];
  const Pose2 body = pose(node);
  if (clearance_m < 0) clearance_m = static_cast<float>(ground_.distance_m(body.position_m()));
  if (clearance_m > std::max(footprint_.semi_long_m, footprint_.semi_short_m)) return true;
  if (clearance_m < std::min(footprint_.semi_long_m, footprint_.semi_short_m)) return false;
  return !ground_.hits(body, footprint_);
}

void Reach::flood(const Pose2& start) {
  std::vector<Node> open;
  const auto reach = [&](Node node) {
    node.heading = (node.heading + headings_) % headings_;
    if (!in_lattice(node) || reached_[index(node)] != 0 || !is_free(node)) return;
    reached_[index(node)] = 1;
    open.push_back(node);
  };
  // The start itself is free, but need not lie on the lattice: all that is next to it counts.
  const Node centre = nearest(start);
  for (int heading = -1; heading <= 1; ++heading) {
    for (int row = -1; row <= 1; ++row) {
      for (int column = -1; column <= 1; ++column) {
        reach({centre.column + column, centre.row + row, centre.heading + heading});
      }
    }
  }
  while (!open.empty()) {
    const Node node = open.back();
    open.pop_back();
    reach({node.column + 1, node.row, node.heading});
    reach({node.column - 1, node.row, node.heading});
    reach({node.column, node.row + 1, node.heading});
    reach({node.column, node.row - 1, node.heading});
    reach({node.column, node.row, node.heading + 1});
    reach({node.column, node.row, node.heading - 1});
  }
}

bool Reach::contains(const Pose2& body) const {
  const Node node = nearest(body);
  return in_lattice(node) && reached_[index(node)] != 0 && !ground_.hits(body, footprint_);
}

}  // namespace arpent::evaluation
