// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent evaluate`: trajectories, meshes and missions against the truth; docs/evaluation.md explains every key.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/atomic_file.h"
#include "common/error.h"
#include "tools/evaluation/mesh.h"
#include "tools/evaluation/trajectory.h"
#include "tools/mission/report_reconstruction.h"

namespace {

using namespace arpent;
using nlohmann::ordered_json;
using tools::evaluate_folder;

void finish(const ordered_json& json, const std::string& file) {
  for (const auto& [key, value] : json.items()) fmt::print("  {:28} {}\n", key, value.dump());
  if (!file.empty()) atomic_write(file, json.dump(1) + "\n");
}

void finish_rows(const nlohmann::json& rows, const std::string& file) {
  for (const auto& row : rows) {
    fmt::print("  {:36} {:.6g} {}\n", row["name"].get<std::string>(), row["value"].get<double>(),
               row["unit"].get<std::string>());
  }
  if (!file.empty()) atomic_write(file, rows.dump(1) + "\n");
}

ordered_json trajectory_json(const evaluation::TrajectoryErrors& e, const std::string& alignment) {
  ordered_json json;
  json["align"] = alignment;
  json["poses"] = e.poses;
  json["path_m"] = e.path_m;
  json["ate_rmse_m"] = e.ate_m.rmse;
  json["ate_mean_m"] = e.ate_m.mean;
  json["ate_median_m"] = e.ate_m.median;
  json["ate_std_m"] = e.ate_m.std;
  json["ate_min_m"] = e.ate_m.min;
  json["ate_max_m"] = e.ate_m.max;
  json["rotation_rmse_deg"] = e.rotation_deg.rmse;
  json["rpe_rmse_m"] = e.rpe_m.rmse;
  json["rpe_rmse_deg"] = e.rpe_deg.rmse;
  json["end_error_percent"] = e.end_error_percent;
  json["segment_lengths_m"] = e.segment_lengths_m;
  json["segments"] = e.segments.segments;
  json["t_rel_percent"] = e.segments.t_rel_percent;
  json["r_rel_deg_per_m"] = e.segments.r_rel_deg_per_m;
  return json;
}

ordered_json mesh_json(const evaluation::MeshErrors& e, double e_max_m) {
  ordered_json json;
  json["e_max_m"] = e_max_m;
  json["reference_samples"] = e.reference_samples;
  json["coverage_percent"] = e.coverage_percent;
  json["rmse_cm"] = e.rmse_cm;
  json["mean_cm"] = e.mean_cm;
  json["std_cm"] = e.std_cm;
  json["m3c2_points"] = e.m3c2_points;
  json["accuracy_rmse_cm"] = e.accuracy_rmse_cm;
  json["accuracy_trim_cm"] = e.accuracy_trim_cm;
  json["beyond_percent"] = e.beyond_percent;
  return json;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Compares trajectories, meshes and missions with the truth."};
  app.name("arpent evaluate");
  std::string reference, estimate, folder, world, report, growth, json_file, alignment = "se3";
  std::vector<double> segments;
  evaluation::MeshParams params;
  auto* trajectory = app.add_subcommand("trajectory", "TUM, KITTI or EuRoC files");
  auto* mesh = app.add_subcommand("mesh", "PLY meshes or clouds");
  auto* mission = app.add_subcommand("mission", "a mission's folder");
  for (auto* command : {trajectory, mesh}) {
    command->add_option("--reference", reference, "the truth")->required();
    command->add_option("--estimate", estimate, "what is judged")->required();
  }
  for (auto* command : {trajectory, mesh, mission}) {
    command->add_option("--json", json_file, "write the figures as JSON");
  }
  mission->add_option("DIR", folder, "what ./arpent mission wrote")->required();
  mission->add_option("--world", world, "world file instead of the one in the mission's log");
  trajectory->add_option("--align", alignment, "alignment of the estimate")
      ->capture_default_str()
      ->check(CLI::IsMember({"se3", "posyaw", "none"}));
  trajectory
      ->add_option("--segments", segments, "segment lengths [m]; default 100..800, or 10..40 for paths under 100 m")
      ->delimiter(',');
  mesh->add_option("--e-max", params.e_max_m, "a point of the truth is covered if the estimate is nearer than this [m]")
      ->required()
      ->check(CLI::PositiveNumber);
  mesh->add_option("--samples-per-m2", params.samples_per_m2, "sampling density")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  mesh->add_option("--seed", params.seed, "seed of the sampling")->capture_default_str();
  mission->add_option("--report", report, "also write a report page about the reconstruction into this folder");
  mission->add_option("--growth", growth, "also write how coverage grew, as CSV");
  app.require_subcommand(1);
  try {
    app.parse(argc, argv);
    if (*trajectory) {
      const auto kind = alignment == "se3"      ? evaluation::Alignment::kSe3
                        : alignment == "posyaw" ? evaluation::Alignment::kPosYaw
                                                : evaluation::Alignment::kNone;
      finish(trajectory_json(evaluation::evaluate(evaluation::read_trajectory(reference),
                                                  evaluation::read_trajectory(estimate), kind, segments),
                             alignment),
             json_file);
    } else if (*mission) {
      finish_rows(evaluate_folder(folder, world), json_file);
      if (!growth.empty()) tools::write_growth(folder, world, growth);
      if (!report.empty()) tools::write_reconstruction_report(folder, world, report);
    } else {
      finish(mesh_json(evaluation::evaluate_mesh(read_ply(reference), read_ply(estimate), params), params.e_max_m),
             json_file);
    }
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "evaluate: %s\n", error.what());
    return 2;
  }
}
