// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/exploration_targets.h"

#include <algorithm>
#include <numbers>
#include <unordered_map>

#include "common/config/config.h"
#include "planning/viewpoints/clustering.h"
#include "planning/viewpoints/cover.h"
#include "planning/viewpoints/generation.h"
#include "planning/viewpoints/pieces.h"

namespace arpent::planning {
namespace {

using mapping::TsdfMap;
using mapping::UnknownRule;

/// A look is taken at a viewpoint if it is within so much of its heading.
constexpr double kAtHeadingRad = 0.26;
/// A few looks from close by are not enough to give a voxel up: one picture may be blurred.
constexpr double kLeastBlankLooks = 4;
/// Viewpoints that complete nothing in two visits will not in a third. A visit that shows that the element cannot be
/// seen from there counts half: from elsewhere it may.
constexpr int kHalfVisits = 4;

/// Viewpoints of the `thesis` preset, and which elements have none.
Cover generate_as_printed(const Sight& sight, const FreeSpace& free_space, const Pose2& robot,
                          const ViewpointParams& params) {
  Cover cover;
  std::vector<mapping::IncompleteElement> elements;
  for (std::uint32_t i = 0; i < sight.elements().size(); ++i) {
    if (!sight.is_given_up(i)) elements.push_back(sight.elements()[i]);
  }
  const auto generated = generate_viewpoints(elements, sight.camera(), params, free_space, robot);
  VoxelSet served;
  for (const Viewpoint& viewpoint : generated) served.insert(viewpoint.elements.begin(), viewpoint.elements.end());
  for (std::uint32_t i = 0; i < sight.elements().size(); ++i) {
    if (!served.contains(sight.elements()[i].voxel)) cover.left.push_back(i);
  }
  cover.viewpoints = merge_viewpoints(generated, params.merge_voxels * sight.voxel_m(),
                                      params.merge_angle_deg * std::numbers::pi / 180, free_space);
  return cover;
}

bool may_show_all(const Sight& sight, std::uint32_t element, const Pose2& pose) {
  const CameraView view(sight.camera(), pose);
  const auto unknowns = sight.unknowns_of(element);
  return std::all_of(unknowns.begin(), unknowns.end(),
                     [&](std::uint32_t u) { return sight.may_show(view, sight.unknowns()[u].centre_m); });
}

/// Viewpoints from which no more is known than that the element would be in sight: the attempt is what settles it.
void add_attempt(std::vector<Viewpoint>& attempts, const Sight& sight, std::uint32_t element,
                 const std::vector<Pose2>& poses, int looks) {
  const VoxelIndex& voxel = sight.elements()[element].voxel;
  for (Viewpoint& attempt : attempts) {
    if (!may_show_all(sight, element, attempt.pose)) continue;
    attempt.elements.push_back(voxel);
    return;
  }
  for (const Pose2& pose : poses) attempts.push_back({pose, {voxel}, looks});
}

/// With a flag for each element of a piece that is too small to go for; empty if none is. What is given up does not
/// make the piece beside it larger.
Skipped small_pieces(const Sight& sight, const ViewpointParams& params) {
  if (params.preset == "thesis" || params.least_piece_m <= 0) return {};
  std::vector<VoxelIndex> voxels;
  std::vector<std::uint8_t> open;
  for (std::size_t i = 0; i < sight.elements().size(); ++i) {
    voxels.push_back(sight.elements()[i].voxel);
    open.push_back(sight.is_given_up(i) ? 0 : 1);
  }
  Skipped small;
  for (const std::size_t size : piece_sizes(voxels, open)) {
    small.push_back(size > 0 && static_cast<double>(size) * sight.voxel_m() < params.least_piece_m ? 1 : 0);
  }
  return small;
}

/// What could be completed but is a piece too small to go for is below the limit of what is sensed.
Certificate judge(const Certifier& certifier, const Sight& sight, std::uint32_t element, const Skipped& small) {
  Certificate certificate = certifier.judge(element);
  if (certificate.verdict != Verdict::kCompletable || small.empty() || small[element] == 0) return certificate;
  const auto count = static_cast<int>(certificate.poses.size());
  const Eigen::Vector3d place_m = sight.unknowns()[sight.unknowns_of(element).front()].centre_m;
  return {certificate.element, Verdict::kBelowSensingLimit, {}, place_m, count, count, true};
}

/// Elements that the usual poses left but that some pose completes become the last viewpoints; the others are what
/// remains, with the reason.
std::vector<Certificate> settle_the_rest(Cover& cover, const Sight& sight, const FreeSpace& free_space,
                                         const Pose2& robot, const ViewpointParams& params, const Skipped& small) {
  std::vector<Certificate> remaining;
  if (cover.postponed) return remaining;
  for (std::uint32_t i = 0; i < small.size(); ++i) {
    if (small[i] != 0) cover.left.push_back(i);
  }
  std::sort(cover.left.begin(), cover.left.end());
  if (cover.left.empty()) return remaining;
  const Certifier certifier(sight, free_space, robot, params);
  std::vector<Pose2> poses;
  std::unordered_map<std::uint32_t, std::vector<Pose2>> poses_of;
  for (const std::uint32_t element : cover.left) {
    Certificate certificate = judge(certifier, sight, element, small);
    poses.insert(poses.end(), certificate.poses.begin(), certificate.poses.end());
    if (certificate.verdict == Verdict::kCompletable && params.preset != "thesis") {
      poses_of.emplace(element, std::move(certificate.poses));
    } else {
      remaining.push_back(std::move(certificate));
    }
  }
  if (params.preset == "thesis") return remaining;  // no viewpoints but those of the equations
  extend_cover(cover, sight, poses, {params.max_looks, kAnyReachM});
  std::vector<Viewpoint> attempts;
  for (const std::uint32_t element : cover.left) {
    const auto found = poses_of.find(element);
    if (found != poses_of.end()) add_attempt(attempts, sight, element, found->second, params.max_looks);
  }
  cover.viewpoints.insert(cover.viewpoints.end(), attempts.begin(), attempts.end());
  return remaining;
}

std::size_t common_count(const std::vector<VoxelIndex>& a, const std::vector<VoxelIndex>& b) {
  std::size_t count = 0;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (mapping::before(*i, *j)) {
      ++i;
    } else if (mapping::before(*j, *i)) {
      ++j;
    } else {
      ++count, ++i, ++j;
    }
  }
  return count;
}

}  // namespace

std::size_t Targets::largest() const {
  std::size_t most = 0;
  for (const Cluster& cluster : clusters) {
    for (const Viewpoint& viewpoint : cluster.viewpoints) most = std::max(most, viewpoint.elements.size());
  }
  return most;
}

/// Looks at a voxel that is still unknown, in weights of W_th.
struct InVain {
  double promised = 0;         ///< by looks that should have measured it
  double blank = 0;            ///< of looks that show it but said nothing, in a row
  double missing_weight = -1;  ///< after the last look; negative before the first
};

struct ExplorationTargets::State {
  ViewpointParams params;
  LevelCamera camera;
  mapping::IncompleteSurface surface;
  std::unordered_map<VoxelIndex, InVain, mapping::BlockHash> in_vain;
  VoxelSet given_up;
  /// How often an element was still incomplete after all looks of a viewpoint meant for it, in half visits.
  std::unordered_map<VoxelIndex, int, mapping::BlockHash> visits;
  std::vector<Cluster> last;
  int next_id = 0;

  /// `blank`: the newest looks said nothing of it.
  void add_look(InVain& sum, const Sight& sight, const CameraView& view, const UnknownVoxel& unknown, bool meant,
                bool blank) const;
  void keep_ids(std::vector<Cluster>& clusters);
  /// What stayed incomplete once is looked at again for long enough to settle it.
  void insist(std::vector<Viewpoint>& viewpoints, const Sight& sight) const;
  /// Unknown voxels for which the last plan has a viewpoint at this pose.
  [[nodiscard]] VoxelSet meant_from(const TsdfMap& map, const Pose2& pose) const;
};

ExplorationTargets::ExplorationTargets(const ViewpointParams& params, const LevelCamera& camera,
                                       std::optional<Eigen::AlignedBox3d> region_map_m)
    : state_(std::make_unique<State>()) {
  config::check(params, "viewpoints");
  state_->params = params;
  state_->camera = camera;
  const UnknownRule rule = params.preset == "thesis" ? UnknownRule::kWeight : UnknownRule::kSignChange;
  state_->surface = mapping::IncompleteSurface(rule, region_map_m);
}

ExplorationTargets::~ExplorationTargets() = default;
ExplorationTargets::ExplorationTargets(ExplorationTargets&&) noexcept = default;
ExplorationTargets& ExplorationTargets::operator=(ExplorationTargets&&) noexcept = default;

const mapping::IncompleteSurface& ExplorationTargets::surface() const {
  return state_->surface;
}

bool ExplorationTargets::is_complete(const Viewpoint& viewpoint) const {
  return std::none_of(viewpoint.elements.begin(), viewpoint.elements.end(),
                      [&](const VoxelIndex& v) { return state_->surface.contains(v); });
}

void ExplorationTargets::update(const TsdfMap& map) {
  state_->surface.update(map);
}

void ExplorationTargets::note_looks(const TsdfMap& map, std::span<const Pose2> poses) {
  const Sight sight(state_->camera, state_->surface, map, state_->given_up);
  std::vector<CameraView> views;
  std::vector<VoxelSet> meant;
  for (const Pose2& pose : poses) {
    views.emplace_back(state_->camera, pose);
    meant.push_back(state_->meant_from(map, pose));
  }
  for (const UnknownVoxel& unknown : sight.unknowns()) {
    if (unknown.given_up) continue;
    InVain& in_vain = state_->in_vain[unknown.voxel];
    const bool fresh = in_vain.missing_weight < 0;
    const bool grew = unknown.missing_weight < in_vain.missing_weight;
    in_vain.missing_weight = unknown.missing_weight;
    if (grew) in_vain.blank = 0;
    for (std::size_t i = 0; i < views.size(); ++i) {
      state_->add_look(in_vain, sight, views[i], unknown, meant[i].contains(unknown.voxel), !fresh && !grew);
    }
    const ViewpointParams& params = state_->params;
    if (in_vain.promised >= params.give_up_factor || in_vain.blank >= params.blank_factor) {
      state_->given_up.insert(unknown.voxel);
    }
  }
}

void ExplorationTargets::note_visit(const TsdfMap& map, const Viewpoint& viewpoint) {
  if (is_complete(viewpoint)) return;
  const Sight sight(state_->camera, state_->surface, map, state_->given_up);
  const CameraView view(state_->camera, viewpoint.pose);
  for (const VoxelIndex& element : viewpoint.elements) {
    if (!state_->surface.contains(element)) continue;
    const auto unknown = state_->surface.unknown_beside(element, map);
    const bool in_sight = std::all_of(unknown.begin(), unknown.end(), [&](const VoxelIndex& voxel) {
      return sight.shows(view, map.centre_m(voxel), kAnyReachM);
    });
    if ((state_->visits[element] += in_sight ? 2 : 1) < kHalfVisits) continue;
    state_->given_up.insert(unknown.begin(), unknown.end());
  }
}

ExplorationTargets::Certification ExplorationTargets::certify(const TsdfMap& map, const FreeSpace& free_space,
                                                              const Pose2& robot) const {
  const Sight sight(state_->camera, state_->surface, map, state_->given_up);
  const Skipped small = small_pieces(sight, state_->params);
  const Certifier certifier(sight, free_space, robot, state_->params);
  Certification certification;
  for (std::uint32_t i = 0; i < sight.elements().size(); ++i) {
    certification.certificates.push_back(judge(certifier, sight, i, small));
  }
  certification.poses = certifier.poses();
  return certification;
}

Targets ExplorationTargets::plan(const TsdfMap& map, const FreeSpace& free_space, const Pose2& robot) {
  const ViewpointParams& params = state_->params;
  const Sight sight(state_->camera, state_->surface, map, state_->given_up);
  const bool thesis = params.preset == "thesis";
  const Skipped small = small_pieces(sight, params);
  Cover cover = thesis ? generate_as_printed(sight, free_space, robot, params)
                       : cover_elements(sight, free_space, robot, params, small);
  Targets targets;
  targets.elements = sight.elements().size();
  if (cover.postponed)
    targets.postponed = cover.left.size() + static_cast<std::size_t>(std::count(small.begin(), small.end(), 1));
  targets.remaining = settle_the_rest(cover, sight, free_space, robot, params, small);
  if (!thesis) state_->insist(cover.viewpoints, sight);
  const Partition partition = thesis ? cluster_by_single_linkage(cover.viewpoints, params)
                                     : cluster_by_drive(cover.viewpoints, params, free_space);
  targets.clusters = make_clusters(cover.viewpoints, partition, sight, params);
  state_->keep_ids(targets.clusters);
  return targets;
}

void ExplorationTargets::State::add_look(InVain& sum, const Sight& sight, const CameraView& view,
                                         const UnknownVoxel& unknown, bool meant, bool blank) const {
  const bool clear = sight.shows(view, unknown.centre_m, params.unknown_reach_m);
  const bool shown = clear || sight.shows(view, unknown.centre_m, kAnyReachM);
  const double weight = 1 / ((unknown.centre_m - view.position_m()).squaredNorm() * sight.known_weight());
  const bool sure = clear && sight.measures(view, unknown);
  const bool tried = meant && (shown || params.preset == "thesis");
  if (sure || tried) sum.promised += weight;
  // Many a wall cannot be measured from afar and can from where its viewpoint would be.
  const double near_m = stand_off_m(camera, params.delta_pose_m, unknown.centre_m.z()) + kFartherM;
  if (shown && blank && view.depth_m(unknown.centre_m) <= near_m) {
    sum.blank += std::min(weight, params.blank_factor / kLeastBlankLooks);
  }
}

void ExplorationTargets::State::insist(std::vector<Viewpoint>& viewpoints, const Sight& sight) const {
  for (Viewpoint& viewpoint : viewpoints) {
    const CameraView view(camera, viewpoint.pose);
    for (const VoxelIndex& element : viewpoint.elements) {
      if (!visits.contains(element)) continue;
      const double depth_m = view.depth_m((element.cast<double>().array() + 0.5) * sight.voxel_m());
      const double looks = std::ceil(params.blank_factor * sight.known_weight() * depth_m * depth_m);
      viewpoint.looks = std::max(viewpoint.looks, static_cast<int>(std::min<double>(looks, params.max_looks)));
    }
  }
}

VoxelSet ExplorationTargets::State::meant_from(const TsdfMap& map, const Pose2& pose) const {
  VoxelSet meant;
  for (const Cluster& cluster : last) {
    for (const Viewpoint& viewpoint : cluster.viewpoints) {
      if ((viewpoint.pose.position_m() - pose.position_m()).norm() > params.lattice_m) continue;
      if (std::abs(wrap_angle(viewpoint.pose.yaw_rad - pose.yaw_rad)) > kAtHeadingRad) continue;
      for (const VoxelIndex& element : viewpoint.elements) {
        if (!surface.contains(element)) continue;
        const auto unknown = surface.unknown_beside(element, map);
        meant.insert(unknown.begin(), unknown.end());
      }
    }
  }
  return meant;
}

void ExplorationTargets::State::keep_ids(std::vector<Cluster>& clusters) {
  std::vector<std::uint8_t> taken(last.size());
  for (Cluster& cluster : clusters) {
    std::size_t best = last.size();
    std::size_t most = std::max<std::size_t>(1, (cluster.elements.size() + 1) / 2);
    for (std::size_t i = 0; i < last.size(); ++i) {
      const std::size_t common = taken[i] != 0 ? 0 : common_count(cluster.elements, last[i].elements);
      if (common < most) continue;
      best = i;
      most = common + 1;
    }
    if (best < last.size()) taken[best] = 1;
    cluster.id = best < last.size() ? last[best].id : next_id++;
  }
  last = clusters;
}

}  // namespace arpent::planning
