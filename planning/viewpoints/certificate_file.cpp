// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/certificate_file.h"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/atomic_file.h"
#include "common/error.h"

namespace arpent::planning {
namespace {

using nlohmann::ordered_json;

constexpr const char* kFormat = "arpent certificate 1";
constexpr std::array kVerdicts{Verdict::kCompletable, Verdict::kOutOfRange, Verdict::kUnreachable, Verdict::kOccluded,
                               Verdict::kBelowSensingLimit};

ordered_json to_json(const Eigen::Vector3d& p) {
  return {p.x(), p.y(), p.z()};
}

Eigen::Vector3d to_vector(const ordered_json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

ordered_json to_json(const LevelCamera& c) {
  return {{"left_slope", c.left_slope},   {"right_slope", c.right_slope},   {"up_slope", c.up_slope},
          {"down_slope", c.down_slope},   {"baseline_m", c.baseline_m},     {"min_range_m", c.min_range_m},
          {"max_range_m", c.max_range_m}, {"p_body_m", to_json(c.p_body_m)}};
}

LevelCamera to_camera(const ordered_json& json) {
  const auto number = [&json](const char* key) { return json.at(key).get<double>(); };
  return {.left_slope = number("left_slope"),
          .right_slope = number("right_slope"),
          .up_slope = number("up_slope"),
          .down_slope = number("down_slope"),
          .baseline_m = number("baseline_m"),
          .min_range_m = number("min_range_m"),
          .max_range_m = number("max_range_m"),
          .p_body_m = to_vector(json.at("p_body_m"))};
}

/// Cells [x, y, bits of the headings], by y, then x.
ordered_json pack(const std::vector<Pose2>& poses, double lattice_m) {
  std::map<std::pair<int, int>, std::uint32_t> cells;
  for (const Pose2& pose : poses) {
    const int heading = static_cast<int>(std::lround(pose.yaw_rad * Certifier::kHeadings / (2 * std::numbers::pi)));
    const std::pair key(static_cast<int>(std::lround(pose.y_m / lattice_m)),
                        static_cast<int>(std::lround(pose.x_m / lattice_m)));
    cells[key] |= 1U << ((heading + Certifier::kHeadings) % Certifier::kHeadings);
  }
  ordered_json packed = ordered_json::array();
  for (const auto& [cell, bits] : cells) packed.push_back({cell.second, cell.first, bits});
  return packed;
}

std::vector<Pose2> unpack(const ordered_json& packed, double lattice_m) {
  std::vector<Pose2> poses;
  for (const auto& row : packed) {
    for (int h = 0; h < Certifier::kHeadings; ++h) {
      if ((row.at(2).get<std::uint32_t>() >> h & 1U) == 0) continue;
      poses.push_back({row.at(0).get<int>() * lattice_m, row.at(1).get<int>() * lattice_m,
                       wrap_angle(2 * std::numbers::pi * h / Certifier::kHeadings)});
    }
  }
  return poses;
}

ordered_json to_json(const Certificate& certificate, double voxel_m) {
  const VoxelIndex& v = certificate.element;
  // An element that could be completed has no unknown voxel in the way: its own centre is its place.
  const bool own = certificate.verdict == Verdict::kCompletable;
  const Eigen::Vector3d place_m =
      own ? Eigen::Vector3d((v.cast<double>().array() + 0.5) * voxel_m) : certificate.unknown_m;
  return {{"voxel", {v.x(), v.y(), v.z()}},   {"label", to_text(certificate.verdict)},
          {"place_m", to_json(place_m)},      {"in_view", certificate.in_view},
          {"in_sight", certificate.in_sight}, {"small_piece", certificate.small_piece}};
}

CertifiedElement to_element(const ordered_json& json) {
  CertifiedElement element;
  const auto& v = json.at("voxel");
  element.voxel = {v.at(0).get<int>(), v.at(1).get<int>(), v.at(2).get<int>()};
  element.place_m = to_vector(json.at("place_m"));
  element.in_view = json.at("in_view").get<int>();
  element.in_sight = json.at("in_sight").get<int>();
  element.small_piece = json.at("small_piece").get<bool>();
  const auto label = json.at("label").get<std::string>();
  for (const Verdict verdict : kVerdicts) {
    if (label != to_text(verdict)) continue;
    element.verdict = verdict;
    return element;
  }
  throw InputError("there is no label " + label);
}

CertificateFile to_file(const ordered_json& json) {
  if (json.at("format").get<std::string>() != kFormat) throw InputError(std::string("its format is not ") + kFormat);
  CertificateFile file;
  CertificateContext& c = file.context;
  c.end = json.at("end").get<std::string>();
  c.reason = json.at("reason").get<std::string>();
  c.map_frame = json.at("map_frame").get<std::string>();
  c.voxel_m = json.at("voxel_m").get<double>();
  c.known_weight = json.at("known_weight").get<double>();
  c.give_up_factor = json.at("give_up_factor").get<double>();
  c.least_piece_m = json.at("least_piece_m").get<double>();
  const Eigen::Vector3d start = to_vector(json.at("start"));
  c.start = {start.x(), start.y(), start.z()};
  c.semi_long_m = json.at("footprint").at("semi_long_m").get<double>();
  c.semi_short_m = json.at("footprint").at("semi_short_m").get<double>();
  c.camera = to_camera(json.at("camera"));
  c.lattice_m = json.at("lattice").at("step_m").get<double>();
  c.poses = unpack(json.at("lattice").at("poses"), c.lattice_m);
  for (const double positive : {c.voxel_m, c.known_weight, c.semi_long_m, c.semi_short_m, c.lattice_m,
                                c.camera.min_range_m, c.camera.max_range_m - c.camera.min_range_m}) {
    if (!(positive > 0)) throw InputError("lengths, weights and ranges must be positive");
  }
  for (const auto& element : json.at("elements")) file.elements.push_back(to_element(element));
  return file;
}

}  // namespace

void write_certificates(const std::filesystem::path& file, const CertificateContext& c,
                        const std::vector<Certificate>& certificates) {
  ordered_json json{{"format", kFormat},
                    {"end", c.end},
                    {"reason", c.reason},
                    {"map_frame", c.map_frame},
                    {"voxel_m", c.voxel_m},
                    {"known_weight", c.known_weight},
                    {"give_up_factor", c.give_up_factor},
                    {"least_piece_m", c.least_piece_m},
                    {"start", {c.start.x_m, c.start.y_m, c.start.yaw_rad}},
                    {"footprint", {{"semi_long_m", c.semi_long_m}, {"semi_short_m", c.semi_short_m}}},
                    {"camera", to_json(c.camera)},
                    {"lattice",
                     {{"step_m", c.lattice_m},
                      {"headings", static_cast<int>(Certifier::kHeadings)},
                      {"poses", pack(c.poses, c.lattice_m)}}},
                    {"elements", ordered_json::array()}};
  for (const Certificate& certificate : certificates) json["elements"].push_back(to_json(certificate, c.voxel_m));
  atomic_write(file, json.dump() + "\n");
}

CertificateFile read_certificates(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file.string() + ": cannot be read");
  try {
    return to_file(ordered_json::parse(in));
  } catch (const std::exception& fault) {
    throw InputError(file.string() + ": is no certificate: " + fault.what());
  }
}

}  // namespace arpent::planning
