// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/team/wire.h"

#include <cmath>
#include <limits>

#include "mapping/surface/incomplete_surface.h"

namespace arpent::planning {
namespace {

constexpr double kMaxM = 1e5;
constexpr double kMaxRate = 100;
constexpr std::size_t kMaxNameLength = 64;
constexpr int kMaxIndex = 1 << 24;
constexpr int kMaxLooks = 10000;

bool is_name(const std::string& name) {
  return !name.empty() && name.size() <= kMaxNameLength;
}
bool is_pose(double x_m, double y_m, double yaw_rad) {
  return std::abs(x_m) < kMaxM && std::abs(y_m) < kMaxM && std::abs(yaw_rad) < kMaxM;
}

viewpoint_t to_wire(const Viewpoint& viewpoint) {
  viewpoint_t message{};
  message.x_m = viewpoint.pose.x_m;
  message.y_m = viewpoint.pose.y_m;
  message.yaw_rad = viewpoint.pose.yaw_rad;
  message.looks = viewpoint.looks;
  const VoxelIndex first = viewpoint.elements.empty() ? VoxelIndex::Zero() : viewpoint.elements.front();
  for (int k = 0; k < 3; ++k) message.first_voxel[k] = first[k];
  for (const VoxelIndex& element : viewpoint.elements) {
    const VoxelIndex offset = element - first;
    if (offset.cwiseAbs().maxCoeff() > std::numeric_limits<std::int16_t>::max()) continue;
    message.offsets.push_back({static_cast<std::int16_t>(offset.x()), static_cast<std::int16_t>(offset.y()),
                               static_cast<std::int16_t>(offset.z())});
  }
  message.count = static_cast<std::int32_t>(message.offsets.size());
  return message;
}

Result<Viewpoint> from_wire(const viewpoint_t& message) {
  if (!is_pose(message.x_m, message.y_m, message.yaw_rad)) return Fault{"a viewpoint that cannot be"};
  if (message.looks < 1 || message.looks > kMaxLooks) return Fault{"a number of looks that cannot be"};
  const VoxelIndex first(message.first_voxel[0], message.first_voxel[1], message.first_voxel[2]);
  if (first.minCoeff() < -kMaxIndex || first.maxCoeff() > kMaxIndex) return Fault{"an element too far away"};
  Viewpoint viewpoint{{message.x_m, message.y_m, message.yaw_rad}, {}, message.looks};
  for (const auto& offset : message.offsets) {
    if (offset.size() != 3) return Fault{"an element that is none"};
    viewpoint.elements.push_back(first + VoxelIndex(offset[0], offset[1], offset[2]));
  }
  return viewpoint;
}

}  // namespace

robot_state_t to_wire(const RobotState& state) {
  robot_state_t message{};
  message.utime = to_utime(state.stamp);
  message.robot = state.robot;
  message.state = static_cast<std::int8_t>(state.state);
  message.x_m = state.body.x_m;
  message.y_m = state.body.y_m;
  message.yaw_rad = state.body.yaw_rad;
  message.speed_mps = state.twist.speed_mps;
  message.turn_rate_radps = state.twist.turn_rate_radps;
  message.position_sigma_m = state.position_sigma_m;
  message.tour = state.tour;
  message.idle = state.idle ? 1 : 0;
  message.has_target = state.target ? 1 : 0;
  const Pose2 target = state.target.value_or(Pose2{});
  message.target_x_m = target.x_m;
  message.target_y_m = target.y_m;
  message.target_yaw_rad = target.yaw_rad;
  message.blocked_by = state.blocked_by;
  for (const Eigen::Vector2d& p : state.path_m) {
    message.path_x_m.push_back(static_cast<float>(p.x()));
    message.path_y_m.push_back(static_cast<float>(p.y()));
  }
  message.path_count = static_cast<std::int32_t>(state.path_m.size());
  return message;
}

Result<RobotState> from_wire(const robot_state_t& message) {
  if (!is_name(message.robot) || message.blocked_by.size() > kMaxNameLength) return Fault{"a name that cannot be"};
  if (message.state < 0 || message.state > static_cast<std::int8_t>(MissionState::kAborted)) {
    return Fault{"unknown mission state"};
  }
  if (!is_pose(message.x_m, message.y_m, message.yaw_rad) ||
      !is_pose(message.target_x_m, message.target_y_m, message.target_yaw_rad)) {
    return Fault{"a pose that cannot be"};
  }
  if (!(std::abs(message.speed_mps) < kMaxRate && std::abs(message.turn_rate_radps) < kMaxRate)) {
    return Fault{"a twist that cannot be"};
  }
  if (!(message.position_sigma_m >= 0 && message.position_sigma_m < kMaxM)) return Fault{"a deviation that cannot be"};
  RobotState state;
  for (std::size_t i = 0; i < message.path_x_m.size(); ++i) {
    const Eigen::Vector2d p(message.path_x_m[i], message.path_y_m[i]);
    if (!(p.cwiseAbs().maxCoeff() < kMaxM)) return Fault{"a way that cannot be"};
    state.path_m.push_back(p);
  }
  state.stamp = from_utime(message.utime);
  state.robot = message.robot;
  state.state = static_cast<MissionState>(message.state);
  state.body = {message.x_m, message.y_m, message.yaw_rad};
  state.twist = {message.speed_mps, message.turn_rate_radps};
  state.position_sigma_m = message.position_sigma_m;
  state.tour = message.tour;
  state.idle = message.idle != 0;
  if (message.has_target != 0) state.target = Pose2{message.target_x_m, message.target_y_m, message.target_yaw_rad};
  state.blocked_by = message.blocked_by;
  return state;
}

tour_t to_wire(const TeamTour& tour) {
  tour_t message{};
  message.utime = to_utime(tour.stamp);
  message.number = tour.number;
  message.robot = tour.robot;
  message.state_utime = to_utime(tour.state_stamp);
  message.valid_s = tour.valid_s;
  message.samples_below = tour.samples_below;
  message.done = tour.done ? 1 : 0;
  for (const Viewpoint& viewpoint : tour.viewpoints) message.viewpoints.push_back(to_wire(viewpoint));
  message.count = static_cast<std::int32_t>(message.viewpoints.size());
  return message;
}

Result<TeamTour> from_wire(const tour_t& message) {
  if (!is_name(message.robot)) return Fault{"a tour for nobody"};
  if (!(message.valid_s > 0 && message.valid_s < 1e4)) return Fault{"a validity that cannot be"};
  TeamTour tour;
  for (const viewpoint_t& viewpoint : message.viewpoints) {
    auto converted = from_wire(viewpoint);
    if (!converted) return Fault{converted.fault()};
    tour.viewpoints.push_back(std::move(*converted));
  }
  tour.stamp = from_utime(message.utime);
  tour.number = message.number;
  tour.robot = message.robot;
  tour.state_stamp = from_utime(message.state_utime);
  tour.valid_s = message.valid_s;
  tour.samples_below = message.samples_below;
  tour.done = message.done != 0;
  return tour;
}

tour_report_t to_wire(const TourReport& report) {
  tour_report_t message{};
  message.utime = to_utime(report.stamp);
  message.robot = report.robot;
  message.event = static_cast<std::int8_t>(report.event.kind);
  message.x_m = report.event.target.x_m;
  message.y_m = report.event.target.y_m;
  message.yaw_rad = report.event.target.yaw_rad;
  return message;
}

Result<TourReport> from_wire(const tour_report_t& message) {
  if (!is_name(message.robot)) return Fault{"a report of nobody"};
  if (message.event != tour_report_t::EVENT_VISITED && message.event != tour_report_t::EVENT_UNREACHABLE) {
    return Fault{"an unknown event"};
  }
  if (!is_pose(message.x_m, message.y_m, message.yaw_rad)) return Fault{"a viewpoint that cannot be"};
  return TourReport{from_utime(message.utime),
                    message.robot,
                    {static_cast<TargetEvent::Kind>(message.event), {message.x_m, message.y_m, message.yaw_rad}}};
}

}  // namespace arpent::planning
