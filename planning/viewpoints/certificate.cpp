// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/certificate.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace arpent::planning {
namespace {

/// Farthest body from which the camera may see a point, on the ground: the corner of the frustum.
double reach_m(const LevelCamera& camera) {
  const double side = std::max(camera.left_slope, camera.right_slope);
  return camera.max_range_m * std::hypot(1.0, side) + camera.p_body_m.head<2>().norm();
}

std::vector<Eigen::Vector2i> cells_within(int cells) {
  std::vector<Eigen::Vector2i> offsets;
  for (int y = -cells; y <= cells; ++y) {
    for (int x = -cells; x <= cells; ++x) {
      if (x * x + y * y <= cells * cells) offsets.emplace_back(x, y);
    }
  }
  std::stable_sort(offsets.begin(), offsets.end(),
                   [](const auto& a, const auto& b) { return a.squaredNorm() < b.squaredNorm(); });
  return offsets;
}

}  // namespace

const char* to_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::kCompletable:
      return "completable";
    case Verdict::kOutOfRange:
      return "out_of_range";
    case Verdict::kUnreachable:
      return "unreachable";
    case Verdict::kOccluded:
      return "occluded";
    case Verdict::kBelowSensingLimit:
      return "below_sensing_limit";
  }
  return "";
}

Certifier::Certifier(const Sight& sight, const FreeSpace& free_space, const Pose2& robot, const ViewpointParams& params)
    : sight_(sight),
      params_(params),
      offsets_(cells_within(static_cast<int>(std::ceil(reach_m(sight.camera()) / params.lattice_m)) + 1)) {
  Eigen::AlignedBox2d box;
  for (const UnknownVoxel& unknown : sight.unknowns()) box.extend(unknown.centre_m.head<2>());
  if (box.isEmpty()) return;
  const double margin_m = reach_m(sight.camera()) + params.lattice_m;
  const Eigen::Vector2i least = ((box.min().array() - margin_m) / params.lattice_m).floor().cast<int>();
  const Eigen::Vector2i most = ((box.max().array() + margin_m) / params.lattice_m).ceil().cast<int>();
  std::vector<Pose2> places;
  for (int y = least.y(); y <= most.y(); ++y) {
    for (int x = least.x(); x <= most.x(); ++x) places.push_back({x * params.lattice_m, y * params.lattice_m, 0});
  }
  const auto distances_m = free_space.distances_m(robot, places);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!distances_m[i]) continue;
    const std::size_t first = poses_.size();
    for (int h = 0; h < kHeadings; ++h) {
      const Pose2 pose{places[i].x_m, places[i].y_m, wrap_angle(2 * std::numbers::pi * h / kHeadings)};
      if (free_space.is_free(pose)) poses_.push_back(pose);
    }
    const auto cell = [&](double value_m) { return static_cast<int>(std::lround(value_m / params.lattice_m)); };
    if (poses_.size() > first) poses_of_[{cell(places[i].x_m), cell(places[i].y_m)}] = {first, poses_.size()};
  }
}

Certifier::Answer Certifier::search(const UnknownVoxel& unknown) const {
  Answer answer;
  const auto cell = [&](double value_m) { return static_cast<int>(std::lround(value_m / params_.lattice_m)); };
  const int x = cell(unknown.centre_m.x()), y = cell(unknown.centre_m.y());
  for (const Eigen::Vector2i& offset : offsets_) {
    const auto here = poses_of_.find({x + offset.x(), y + offset.y()});
    if (here == poses_of_.end()) continue;
    for (std::size_t i = here->second.first; i < here->second.second; ++i) {
      const CameraView view(sight_.camera(), poses_[i]);
      if (!view.contains(unknown.centre_m)) continue;
      ++answer.in_view;
      if (!sight_.may_show(view, unknown.centre_m)) continue;
      ++answer.in_sight;
      if (unknown.given_up || params_.max_looks * Sight::share_of_look(view, unknown) < 1) continue;
      const bool sure = sight_.measures(view, unknown);
      if (sure || answer.verdict != Verdict::kCompletable) answer.pose = poses_[i];
      answer.verdict = Verdict::kCompletable;
      if (sure) return answer;
    }
  }
  if (answer.verdict == Verdict::kCompletable) return answer;
  answer.verdict = answer.in_sight > 0  ? Verdict::kBelowSensingLimit
                   : answer.in_view > 0 ? Verdict::kOccluded
                                        : Verdict::kUnreachable;
  return answer;
}

Certifier::Answer Certifier::judge_unknown(const UnknownVoxel& unknown) const {
  const LevelCamera& camera = sight_.camera();
  const double needed_m = camera.stand_off_for_height_m(unknown.centre_m.z() - camera.p_body_m.z());
  if (needed_m > camera.max_range_m) return {.verdict = Verdict::kOutOfRange};
  return search(unknown);
}

Certificate Certifier::judge(std::size_t element) const {
  Certificate certificate{.element = sight_.elements()[element].voxel};
  for (const std::uint32_t u : sight_.unknowns_of(element)) {
    const UnknownVoxel& unknown = sight_.unknowns()[u];
    const Answer answer = judge_unknown(unknown);
    if (answer.verdict != Verdict::kCompletable) {
      return {certificate.element, answer.verdict, {}, unknown.centre_m, answer.in_view, answer.in_sight};
    }
    auto& poses = certificate.poses;
    if (std::find(poses.begin(), poses.end(), answer.pose) == poses.end()) poses.push_back(answer.pose);
  }
  return certificate;
}

}  // namespace arpent::planning
