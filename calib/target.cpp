// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/target.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <set>

#include "common/error.h"

namespace arpent::calib {
namespace {

/// Tags of the family 36h11.
constexpr int kFamilySize = 587;

class Reader {
 public:
  Reader(const YAML::Node& root, std::vector<std::string>& faults) : root_(root), faults_(faults) {}

  template <class T>
  void required(const char* key, T& value) {
    if (root_[key]) {
      optional(key, value);
    } else {
      faults_.push_back(fmt::format("{} is missing", key));
    }
    known_.insert(key);
  }
  template <class T>
  void optional(const char* key, T& value) {
    known_.insert(key);
    if (!root_[key]) return;
    try {
      value = root_[key].as<T>();
    } catch (const YAML::Exception&) {
      faults_.push_back(fmt::format("{} is no {}", key, std::is_same_v<T, int> ? "whole number" : "number"));
    }
  }
  void reject_unknown() {
    for (const auto& entry : root_) {
      const auto key = entry.first.as<std::string>();
      if (!known_.contains(key)) faults_.push_back(fmt::format("{} is no key of this target_type", key));
    }
  }

 private:
  const YAML::Node& root_;
  std::vector<std::string>& faults_;
  std::set<std::string> known_{"target_type"};
};

Target read_target(const YAML::Node& root, std::vector<std::string>& faults) {
  Target target;
  Reader reader(root, faults);
  const std::string type = root["target_type"] ? root["target_type"].as<std::string>() : "";
  if (type == "aprilgrid") {
    reader.required("tagRows", target.rows);
    reader.required("tagCols", target.columns);
    reader.required("tagSize", target.tag_m);
    reader.required("tagSpacing", target.spacing_ratio);
    reader.optional("tagBorder", target.border_cells);
    reader.optional("firstId", target.first_id);
  } else if (type == "checkerboard") {
    target.kind = TargetKind::kChessboard;
    reader.required("targetRows", target.rows);
    reader.required("targetCols", target.columns);
    reader.required("rowSpacingMeters", target.row_m);
    reader.required("colSpacingMeters", target.column_m);
  } else {
    faults.push_back(fmt::format("target_type must be aprilgrid or checkerboard, not '{}'", type));
    return target;
  }
  reader.reject_unknown();
  return target;
}

bool is_length(double value_m) {
  return std::isfinite(value_m) && value_m > 0 && value_m < 10;
}

}  // namespace

Eigen::Vector2d Target::corner_m(int corner) const {
  ARPENT_ASSERT(corner >= 0 && corner < corner_count());
  if (kind == TargetKind::kChessboard) return {corner % columns * column_m, corner / columns * row_m};
  const int tag = corner / 4, k = corner % 4;
  return {tag % columns * tag_pitch_m() + (k == 1 || k == 2 ? tag_m : 0),
          tag / columns * tag_pitch_m() + (k >= 2 ? tag_m : 0)};
}

Eigen::Vector2d Target::size_m() const {
  if (kind == TargetKind::kChessboard) return {(columns + 1) * column_m, (rows + 1) * row_m};
  const double gap_m = tag_m * spacing_ratio;
  return {columns * tag_pitch_m() + gap_m, rows * tag_pitch_m() + gap_m};
}

std::vector<std::string> find_faults(const Target& target) {
  std::vector<std::string> faults;
  if (target.kind == TargetKind::kChessboard) {
    if (target.rows < 3 || target.columns < 3 || target.rows * target.columns < 12 || target.rows > 100 ||
        target.columns > 100) {
      faults.emplace_back("targetRows and targetCols count inner corners and must be 3 to 100, 12 corners at least");
    }
    if (!is_length(target.row_m) || !is_length(target.column_m)) {
      faults.emplace_back("rowSpacingMeters and colSpacingMeters must be > 0 [m]");
    }
    return faults;
  }
  if (target.rows < 1 || target.columns < 1 || target.first_id < 0 || target.rows > kFamilySize ||
      target.columns > kFamilySize || target.first_id + target.rows * target.columns > kFamilySize) {
    faults.push_back(fmt::format("tagRows x tagCols tags must be 1 to {} (the family 36h11)", kFamilySize));
  }
  if (!is_length(target.tag_m)) faults.emplace_back("tagSize must be > 0 [m]");
  if (!(target.spacing_ratio > 0 && target.spacing_ratio <= 2)) {
    faults.emplace_back("tagSpacing is the gap over the tag's size (e.g. 0.3), not metres; it must be > 0, <= 2");
  }
  if (target.border_cells != 1 && target.border_cells != 2) faults.emplace_back("tagBorder must be 1 or 2 cells");
  return faults;
}

Target load_target(const std::filesystem::path& file) {
  std::vector<std::string> faults;
  Target target;
  try {
    const YAML::Node root = YAML::LoadFile(file.string());
    if (!root.IsMap()) throw InputError(file.string() + ": is no target.yaml");
    target = read_target(root, faults);
  } catch (const YAML::BadFile&) {
    throw InputError(file.string() + ": cannot be read");
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}:{}: {}", file.string(), error.mark.line + 1, error.msg));
  }
  if (faults.empty()) faults = find_faults(target);
  if (!faults.empty()) throw InputError(fmt::format("{}: {}", file.string(), fmt::join(faults, "; ")));
  return target;
}

std::string to_yaml(const Target& target) {
  if (target.kind == TargetKind::kChessboard) {
    return fmt::format(
        "target_type: checkerboard\ntargetRows: {}  # inner corners\ntargetCols: {}\nrowSpacingMeters: "
        "{}\ncolSpacingMeters: {}\n",
        target.rows, target.columns, target.row_m, target.column_m);
  }
  return fmt::format(
      "target_type: aprilgrid\ntagRows: {}\ntagCols: {}\ntagSize: {}  # outer edge of the black square "
      "[m]\ntagSpacing: "
      "{}  # gap between two tags over tagSize\ntagBorder: {}  # black cells\nfirstId: {}\n",
      target.rows, target.columns, target.tag_m, target.spacing_ratio, target.border_cells, target.first_id);
}

}  // namespace arpent::calib
