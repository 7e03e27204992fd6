// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/certificate/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <arpent/body_pose_t.hpp>
#include <arpent/depth_t.hpp>
#include <set>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "perception/fusion/wire.h"
#include "planning/viewpoints/pieces.h"
#include "tools/evaluation/surface_index.h"
#include "tools/mission/evaluate.h"

namespace arpent::tools {
namespace {

using planning::CertifiedElement;
using planning::Verdict;

/// Visible true surface that the mesh lacks.
class MissingSurface {
 public:
  MissingSurface(const evaluation::TrueSurface& truth, const evaluation::Reconstruction& reconstruction, double reach_m)
      : reach_m_(reach_m), grid_(reach_m) {
    for (std::size_t i = 0; i < reconstruction.covered.size(); ++i) {
      if (reconstruction.covered[i] != 0) continue;
      grid_.add(truth.visible.points_m[i], static_cast<int>(points_m_.size()));
      points_m_.push_back(truth.visible.points_m[i]);
    }
  }
  [[nodiscard]] bool is_near(const Eigen::Vector3d& p) const {
    return grid_.any_around(p, [&](int i) { return (points_m_[static_cast<std::size_t>(i)] - p).norm() < reach_m_; });
  }
  [[nodiscard]] std::size_t size() const { return points_m_.size(); }

 private:
  double reach_m_;
  std::vector<Eigen::Vector3d> points_m_;
  evaluation::PointGrid grid_;
};

/// What the looks at a place are worth, by the map's weight 1/z^2.
double weight_of_looks(const planning::LevelCamera& camera, const CertificateEvidence& evidence,
                       const Eigen::Vector3d& place_m, double stop_short_m) {
  double sum = 0;
  for (const Pose2& body : evidence.looks) {
    const planning::CameraView view(camera, body);
    if (!view.contains(place_m) || !evidence.views.in_line_of_sight(view.position_m(), place_m, stop_short_m)) continue;
    sum += 1 / (view.depth_m(place_m) * view.depth_m(place_m));
  }
  return sum;
}

/// For each element the length of its piece, taken as a line of voxels [m]: of what was left because it is small, or
/// could be completed. Zero for the others, each of which has a reason of its own.
std::vector<double> piece_lengths_m(const planning::CertificateFile& file) {
  std::vector<planning::VoxelIndex> voxels;
  std::vector<std::uint8_t> left;
  for (const CertifiedElement& element : file.elements) {
    voxels.push_back(element.voxel);
    left.push_back(element.small_piece || element.verdict == Verdict::kCompletable ? 1 : 0);
  }
  std::vector<double> lengths_m;
  for (const std::size_t size : planning::piece_sizes(voxels, left)) {
    lengths_m.push_back(static_cast<double>(size) * file.context.voxel_m);
  }
  return lengths_m;
}

/// Whether no legal pose has the place in sight, as far as a map of such voxels can tell: surface may be h off, towards
/// the place and to the sides of the line of sight.
bool is_out_of_sight(const Eigen::Vector3d& place_m, const evaluation::LegalViews& views, double tolerance_m,
                     std::string& remark) {
  const auto count = views.count(place_m, tolerance_m, tolerance_m);
  const int at_all = views.count(place_m, tolerance_m).in_sight;
  remark += fmt::format("in view from {} legal poses, in sight from {}, {} of them with {:.2f} m to spare",
                        count.in_view, at_all, count.in_sight, tolerance_m);
  return count.in_sight == 0;
}

/// Does the reason hold in the true world? The remark says what was found.
bool holds(const CertifiedElement& element, const planning::CertificateContext& context,
           const CertificateEvidence& evidence, double piece_m, std::string& remark) {
  const planning::LevelCamera& camera = context.camera;
  const double tolerance_m = evaluation::e_max_m(context.voxel_m);
  if (element.verdict == Verdict::kOutOfRange) {
    const double stand_off_m = camera.stand_off_for_height_m(element.place_m.z() - camera.p_body_m.z());
    remark = fmt::format("in view from {:.2f} m on", stand_off_m);
    return stand_off_m > camera.max_range_m;
  }
  if (element.verdict == Verdict::kBelowSensingLimit && element.small_piece) {
    remark = fmt::format("a piece of {:.2f} m, less than {:.2f} are left", piece_m, context.least_piece_m);
    return piece_m < context.least_piece_m;
  }
  if (element.verdict == Verdict::kBelowSensingLimit) {
    const double weight = weight_of_looks(camera, evidence, element.place_m, tolerance_m);
    const double enough = context.give_up_factor * context.known_weight;
    remark = fmt::format("looks worth {:.2f}, {:.2f} are enough", weight, enough);
    if (weight >= enough) return true;
    remark += "; ";
    return is_out_of_sight(element.place_m, evidence.views, tolerance_m, remark);
  }
  if (element.verdict == Verdict::kCompletable) {
    remark = "says itself that it could be completed";
    return false;
  }
  return is_out_of_sight(element.place_m, evidence.views, tolerance_m, remark);
}

double contact_percent(const planning::CertificateContext& context, const sim::World& world) {
  const sim::GroundMap ground(world);
  const sim::EllipseFootprint footprint{context.semi_long_m, context.semi_short_m};
  const auto touching = std::count_if(context.poses.begin(), context.poses.end(),
                                      [&](const Pose2& pose) { return ground.hits(pose, footprint); });
  return 100.0 * static_cast<double>(touching) / static_cast<double>(std::max<std::size_t>(1, context.poses.size()));
}

}  // namespace

double CertificateCheck::valid_percent() const {
  return elements.empty() ? 100 : 100.0 * (true_count + moot_count) / static_cast<double>(elements.size());
}

double CertificateCheck::true_percent() const {
  return elements.empty() ? 100 : 100.0 * true_count / static_cast<double>(elements.size());
}

CertificateCheck check_certificates(const planning::CertificateFile& file, const CertificateEvidence& evidence) {
  CertificateCheck check;
  // A missing piece of surface belongs to an element if it touches the element's voxel or one beside it.
  const double reach_m = 3 * evaluation::e_max_m(file.context.voxel_m);
  const MissingSurface missing(evidence.truth, evidence.reconstruction, reach_m);
  const auto points =
      static_cast<double>(evidence.truth.visible.points_m.size() + evidence.truth.hidden.points_m.size());
  check.uncovered_m2 = evidence.truth.area_m2 * static_cast<double>(missing.size()) / std::max(1.0, points);
  const std::vector<double> lengths_m = piece_lengths_m(file);
  for (std::size_t i = 0; i < file.elements.size(); ++i) {
    const CertifiedElement& element = file.elements[i];
    CheckedElement checked{element, Finding::kFalse, ""};
    if (holds(element, file.context, evidence, lengths_m[i], checked.remark)) {
      checked.finding = Finding::kTrue;
    } else if (!missing.is_near(element.place_m)) {
      checked.finding = Finding::kMoot;
    }
    check.true_count += checked.finding == Finding::kTrue ? 1 : 0;
    check.moot_count += checked.finding == Finding::kMoot ? 1 : 0;
    check.false_count += checked.finding == Finding::kFalse ? 1 : 0;
    check.small_pieces += element.small_piece ? 1 : 0;
    check.unfinished += element.verdict == Verdict::kCompletable ? 1 : 0;
    check.elements.push_back(std::move(checked));
  }
  return check;
}

Looks read_looks(const std::filesystem::path& log) {
  std::set<std::int64_t> depths;
  std::map<std::int64_t, Pose2> poses;
  LogReader reader(log);
  while (const auto event = reader.next()) {
    if (event->channel == channels::kDepth) {
      depth_t message;
      std::string fault;
      if (decode_guarded(event->data, message, fault)) depths.insert(message.utime);
    } else if (event->channel == channels::kPairPose) {
      body_pose_t message;
      std::string fault;
      if (!decode_guarded(event->data, message, fault)) continue;
      const auto pose = fusion::from_wire(message);
      if (pose && pose->status != fusion::Status::kLost && pose->frame == fusion::Frame::kWorld)
        poses.emplace(to_utime(pose->stamp), to_pose2(pose->T_frame_body));
    }
  }
  Looks looks;
  for (const auto& [utime, pose] : poses) {
    if (depths.contains(utime)) looks.push_back(pose);
  }
  return looks;
}

CertificateCheck check_folder(const std::filesystem::path& folder, const std::filesystem::path& world) {
  const planning::CertificateFile file = planning::read_certificates(folder / "certificate.json");
  if (file.context.map_frame != "world") {
    throw InputError("the certificate is in the frame " + file.context.map_frame + ": only world can be compared");
  }
  const MissionFolder mission = read_mission_folder(folder, world);
  const MissionEvaluation evaluation = evaluate_mission(mission.setting, mission.result, legal_views(mission.setting));
  evaluation::LegalViewParams params;
  const double grown_m = evaluation::e_max_m(file.context.voxel_m);
  params.footprint = {file.context.semi_long_m + grown_m, file.context.semi_short_m + grown_m};
  params.camera = file.context.camera;
  const evaluation::LegalViews views(mission.setting.world, mission.setting.start, params);
  const Looks looks = read_looks(mission.result.log);
  CertificateCheck check = check_certificates(file, {views, evaluation.truth, evaluation.reconstruction, looks});
  check.in_contact_percent = contact_percent(file.context, mission.setting.world);
  return check;
}

}  // namespace arpent::tools
