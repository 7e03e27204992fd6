// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <map>

#include "common/error.h"
#include "common/split.h"
#include "tools/datasets/dataset.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw InputError(fmt::format("{}: {}", file.string(), what));
}

/// The cells of each line of a csv file that is no comment.
std::vector<std::vector<std::string>> read_csv(const fs::path& file) {
  std::ifstream in(file);
  if (!in || fs::is_directory(file)) fail(file, "cannot be read");
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    for (const std::string& cell : split(line, ',')) {
      const auto start = cell.find_first_not_of(' ');
      cells.push_back(start == std::string::npos ? "" : cell.substr(start));
    }
    rows.push_back(std::move(cells));
  }
  return rows;
}

std::int64_t to_utime(const std::string& nanoseconds, const fs::path& file) {
  try {
    return std::stoll(nanoseconds) / 1000;
  } catch (const std::exception&) {
    fail(file, "'" + nanoseconds + "' is no time stamp in nanoseconds");
  }
}

std::map<std::int64_t, fs::path> read_images(const fs::path& camera) {
  std::map<std::int64_t, fs::path> images;
  for (const auto& row : read_csv(camera / "data.csv")) {
    if (row.size() < 2) fail(camera / "data.csv", "a line is not `time, file`");
    images[to_utime(row[0], camera / "data.csv")] = camera / "data" / row[1];
  }
  return images;
}

struct Camera {
  RawCamera raw;
  Pose T_body_cam;
};

Camera read_camera(const fs::path& file) {
  try {
    const YAML::Node node = YAML::LoadFile(file.string());
    const auto T = node["T_BS"]["data"].as<std::vector<double>>();
    const auto size = node["resolution"].as<std::vector<int>>();
    const auto K = node["intrinsics"].as<std::vector<double>>();
    const auto D = node["distortion_coefficients"].as<std::vector<double>>();
    const auto model = node["distortion_model"].as<std::string>();
    if (T.size() != 16 || size.size() != 2 || K.size() != 4 || D.size() > 5)
      fail(file, "has lists of the wrong length");
    Camera camera;
    camera.raw.pinhole = {size[0], size[1], K[0], K[1], K[2], K[3]};
    if (model != "equidistant" && model != "radial-tangential" && model != "radtan") {
      fail(file, "distortion_model must be radial-tangential or equidistant, not " + model);
    }
    camera.raw.distortion = model == "equidistant" ? DistortionModel::kEquidistant : DistortionModel::kRadialTangential;
    std::copy(D.begin(), D.end(), camera.raw.coefficients.begin());
    camera.T_body_cam.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(T.data());
    return camera;
  } catch (const YAML::Exception& error) {
    fail(file, error.what());
  }
}

std::vector<TruePose> read_truth(const fs::path& file) {
  std::vector<TruePose> truth;
  if (!fs::exists(file)) return truth;
  for (const auto& row : read_csv(file)) {
    if (row.size() < 8) fail(file, "a line has fewer than 8 numbers");
    double v[7];
    for (std::size_t i = 0; i < 7; ++i) {
      char* end = nullptr;
      v[i] = std::strtod(row[i + 1].c_str(), &end);
      if (end == row[i + 1].c_str()) fail(file, fmt::format("'{}' is no number", row[i + 1]));
    }
    const auto T = make_pose({v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]});
    if (!T) fail(file, fmt::format("the pose at {} is no rigid motion", row[0]));
    truth.push_back({from_utime(to_utime(row[0], file)), *T});
  }
  return truth;
}

}  // namespace

Dataset read_euroc(const fs::path& folder) {
  if (!fs::is_directory(folder)) fail(folder, "there is no such folder");
  const fs::path root = fs::is_directory(folder / "mav0") ? folder / "mav0" : folder;
  const Camera left = read_camera(root / "cam0" / "sensor.yaml");
  const Camera right = read_camera(root / "cam1" / "sensor.yaml");
  Dataset dataset;
  dataset.name = "euroc";
  dataset.trajectory_frame = "cam0";
  dataset.calibration = {left.raw, right.raw, right.T_body_cam.inverse() * left.T_body_cam, left.T_body_cam};
  const auto faults = find_faults(dataset.calibration);
  if (!faults.empty()) fail(root, fmt::format("{}", fmt::join(faults, "; ")));
  const auto left_images = read_images(root / "cam0");
  const auto right_images = read_images(root / "cam1");
  for (const auto& [utime, file] : left_images) {
    const auto partner = right_images.find(utime);
    if (partner == right_images.end()) continue;
    dataset.frames.push_back({from_utime(utime), file, partner->second});
  }
  dataset.unpaired = static_cast<int>(left_images.size() + right_images.size() - 2 * dataset.frames.size());
  if (dataset.frames.empty()) fail(root, "has no pair of images with the same time stamp");
  if (dataset.frames.size() > 1) {
    dataset.rate_hz = static_cast<double>(dataset.frames.size() - 1) /
                      to_seconds(dataset.frames.back().stamp - dataset.frames.front().stamp);
  }
  dataset.truth = read_truth(root / "state_groundtruth_estimate0" / "data.csv");
  return dataset;
}

}  // namespace arpent::tools
