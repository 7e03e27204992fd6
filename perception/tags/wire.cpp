// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/wire.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace arpent::tags {
namespace {

constexpr char kWorldFrame[] = "world";
constexpr char kBodyFrame[] = "body";
constexpr char kOdomFrame[] = "odom";

void write_pose(const Pose& pose, double (&position_m)[3], double (&orientation_wxyz)[4]) {
  for (int i = 0; i < 3; ++i) position_m[i] = pose.translation()[i];
  const Eigen::Quaterniond q = canonical_quaternion(pose.linear());
  const double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  std::copy(wxyz, wxyz + 4, orientation_wxyz);
}

std::optional<Pose> read_pose(const double (&position_m)[3], const double (&wxyz)[4]) {
  return make_pose(Eigen::Map<const Eigen::Vector3d>(position_m), {wxyz[0], wxyz[1], wxyz[2], wxyz[3]});
}

void write_covariance(const Matrix6d& from, double (&to)[6][6]) {
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) to[r][c] = from(r, c);
  }
}

Matrix6d read_covariance(const double (&from)[6][6]) {
  Matrix6d covariance;
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) covariance(r, c) = from[r][c];
  }
  return covariance;
}

bool has_positive_variances(const Matrix6d& covariance) {
  return covariance.allFinite() && (covariance.diagonal().array() > 0).all();
}

Result<TagDetection> read_tag(const tag_t& message) {
  TagDetection tag{message.id, message.hamming, message.decision_margin, {}};
  if (tag.id < 0 || tag.id >= kFamilySize) return Fault{"a tag's id is not of the family"};
  if (tag.hamming < 0 || !std::isfinite(tag.decision_margin)) return Fault{"a tag's quality is out of range"};
  for (std::size_t k = 0; k < 4; ++k) {
    tag.corners_px[k] = {message.corners_px[k][0], message.corners_px[k][1]};
    if (!tag.corners_px[k].allFinite()) return Fault{"a tag's corner is not finite"};
  }
  return tag;
}

tag_t write_tag(const TagDetection& tag) {
  tag_t message{};
  message.id = tag.id;
  message.hamming = tag.hamming;
  message.decision_margin = tag.decision_margin;
  for (std::size_t k = 0; k < 4; ++k) {
    message.corners_px[k][0] = tag.corners_px[k].x();
    message.corners_px[k][1] = tag.corners_px[k].y();
  }
  return message;
}

}  // namespace

BodyObservation to_body(Time stamp, std::int64_t sequence, const Observation& observation) {
  BodyObservation body{stamp, sequence, observation.tags, observation.accepted(), observation.reason, {}, {}};
  body.T_world_body = observation.T_world_body;
  body.covariance = observation.covariance;
  return body;
}

tag_observation_t to_wire(const BodyObservation& observation) {
  tag_observation_t message{};
  message.utime = to_utime(observation.stamp);
  message.sequence = observation.sequence;
  message.count = static_cast<std::int32_t>(observation.tags.size());
  std::transform(observation.tags.begin(), observation.tags.end(), std::back_inserter(message.tags), write_tag);
  message.accepted = observation.accepted ? 1 : 0;
  message.reason = observation.reason;
  message.frame = kWorldFrame;
  message.child_frame = kBodyFrame;
  write_pose(observation.T_world_body, message.position_m, message.orientation_wxyz);
  write_covariance(observation.covariance, message.covariance);
  return message;
}

Result<BodyObservation> from_wire(const tag_observation_t& message) {
  if (message.frame != kWorldFrame || message.child_frame != kBodyFrame) return Fault{"frames are not world and body"};
  if (message.accepted != 0 && message.accepted != 1) return Fault{"accepted is neither 0 nor 1"};
  BodyObservation observation;
  observation.stamp = from_utime(message.utime);
  observation.sequence = message.sequence;
  for (const tag_t& wire : message.tags) {
    const auto tag = read_tag(wire);
    if (!tag) return Fault{tag.fault()};
    observation.tags.push_back(*tag);
  }
  observation.accepted = message.accepted != 0;
  observation.reason = message.reason;
  const auto pose = read_pose(message.position_m, message.orientation_wxyz);
  if (!pose) return Fault{"the pose is not a rigid motion"};
  observation.T_world_body = *pose;
  observation.covariance = read_covariance(message.covariance);
  if (!observation.covariance.allFinite()) return Fault{"the covariance is not finite"};
  if (observation.accepted && !has_positive_variances(observation.covariance)) {
    return Fault{"an accepted pose has a variance that is not positive"};
  }
  return observation;
}

frame_alignment_t to_wire(const Alignment& alignment) {
  frame_alignment_t message{};
  message.utime = to_utime(alignment.stamp);
  message.frame = kWorldFrame;
  message.child_frame = kOdomFrame;
  write_pose(alignment.T_world_odom, message.position_m, message.orientation_wxyz);
  write_covariance(alignment.covariance, message.covariance);
  message.views = alignment.views;
  return message;
}

Result<Alignment> from_wire(const frame_alignment_t& message) {
  if (message.frame != kWorldFrame || message.child_frame != kOdomFrame) return Fault{"frames are not world and odom"};
  if (message.views < 1) return Fault{"it was made from no view"};
  const auto pose = read_pose(message.position_m, message.orientation_wxyz);
  if (!pose) return Fault{"the pose is not a rigid motion"};
  Alignment alignment;
  alignment.stamp = from_utime(message.utime);
  alignment.T_world_odom = *pose;
  alignment.covariance = read_covariance(message.covariance);
  if (!has_positive_variances(alignment.covariance)) return Fault{"a variance is not positive"};
  alignment.views = message.views;
  return alignment;
}

}  // namespace arpent::tags
