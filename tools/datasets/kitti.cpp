// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>

#include "common/error.h"
#include "tools/datasets/dataset.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using Row12 = std::array<double, 12>;

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw InputError(fmt::format("{}: {}", file.string(), what));
}

std::ifstream open(const fs::path& file) {
  std::ifstream in(file);
  if (!in || fs::is_directory(file)) fail(file, "cannot be read");
  return in;
}

/// Twelve numbers of a 3 x 4 matrix, row by row; nullopt if there are not exactly so many.
std::optional<Row12> parse_row(const std::string& text) {
  std::istringstream in(text);
  Row12 row{};
  for (double& value : row) {
    std::string word;
    if (!(in >> word)) return std::nullopt;
    char* end = nullptr;
    value = std::strtod(word.c_str(), &end);
    if (end == word.c_str() || *end != '\0') return std::nullopt;
  }
  std::string rest;
  return in >> rest ? std::nullopt : std::optional(row);
}

/// P0 and P1 of calib.txt: labelled lines, or the first two lines.
std::pair<Row12, Row12> read_projections(const fs::path& file) {
  std::ifstream in = open(file);
  std::map<std::string, Row12> projections;
  int unlabelled = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    std::string label = fmt::format("P{}", unlabelled);
    const auto colon = line.find(':');
    if (colon != std::string::npos) {
      label = line.substr(0, colon);
      line = line.substr(colon + 1);
    } else {
      ++unlabelled;
    }
    if (label != "P0" && label != "P1") continue;
    const auto row = parse_row(line);
    if (!row) fail(file, label + " is not 12 numbers");
    projections[label] = *row;
  }
  if (!projections.contains("P0") || !projections.contains("P1")) fail(file, "has no P0 and P1");
  return {projections["P0"], projections["P1"]};
}

StereoCalibration to_calibration(const Row12& P0, const Row12& P1, cv::Size size, const fs::path& file) {
  StereoCalibration calibration;
  calibration.left.pinhole = {size.width, size.height, P0[0], P0[5], P0[2], P0[6]};
  calibration.right.pinhole = {size.width, size.height, P1[0], P1[5], P1[2], P1[6]};
  calibration.T_right_left.translation().x() = (P1[3] - P0[3]) / P1[0];
  calibration.T_body_left.linear() = R_body_from_camera_axes();
  const auto faults = find_faults(calibration);
  if (!faults.empty()) fail(file, fmt::format("{}", fmt::join(faults, "; ")));
  if (P0[1] != 0 || P1[1] != 0 || !(calibration.left.pinhole == calibration.right.pinhole)) {
    fail(file, "P0 and P1 must be those of a rectified pair: equal but for the baseline, without skew");
  }
  return calibration;
}

std::vector<fs::path> list_images(const fs::path& folder) {
  if (!fs::is_directory(folder)) fail(folder, "there is no such folder of images");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".png" || extension == ".jpg" || extension == ".pgm") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<double> read_times(const fs::path& file, std::size_t count) {
  std::vector<double> times_s;
  if (!fs::exists(file)) {
    for (std::size_t i = 0; i < count; ++i) times_s.push_back(0.1 * static_cast<double>(i));
    return times_s;
  }
  std::ifstream in = open(file);
  for (double t = 0; in >> t;) times_s.push_back(t);
  if (times_s.size() < count) fail(file, fmt::format("has {} times for {} images", times_s.size(), count));
  constexpr double kLongestS = 1e7;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(std::abs(times_s[i]) < kLongestS)) fail(file, fmt::format("line {}: is no time in seconds", i + 1));
  }
  for (std::size_t i = 1; i < count; ++i) {
    if (!(times_s[i] > times_s[i - 1])) fail(file, fmt::format("line {}: times must ascend", i + 1));
  }
  return times_s;
}

std::vector<TruePose> read_poses(const fs::path& file, const std::vector<DatasetFrame>& frames,
                                 const Pose& T_body_cam) {
  std::vector<TruePose> truth;
  if (!fs::exists(file)) return truth;
  std::ifstream in = open(file);
  for (std::string line; std::getline(in, line) && truth.size() < frames.size();) {
    const auto row = parse_row(line);
    if (!row) fail(file, fmt::format("line {} is not 12 numbers", truth.size() + 1));
    Eigen::Matrix3d R;
    R << (*row)[0], (*row)[1], (*row)[2], (*row)[4], (*row)[5], (*row)[6], (*row)[8], (*row)[9], (*row)[10];
    const auto T = make_pose({(*row)[3], (*row)[7], (*row)[11]}, Eigen::Quaterniond(R));
    if (!T || !(R * R.transpose()).isIdentity(1e-3))
      fail(file, fmt::format("line {} is no rigid motion", truth.size() + 1));
    truth.push_back({frames[truth.size()].stamp, T_body_cam * *T * T_body_cam.inverse()});
  }
  return truth;
}

}  // namespace

Dataset read_kitti(const fs::path& folder) {
  if (!fs::is_directory(folder)) fail(folder, "there is no such folder");
  const auto left = list_images(folder / "image_0");
  const auto right = list_images(folder / "image_1");
  if (left.empty()) fail(folder / "image_0", "has no images");
  if (left.size() != right.size()) {
    fail(folder, fmt::format("image_0 has {} images and image_1 {}", left.size(), right.size()));
  }
  const cv::Mat first = cv::imread(left.front().string(), cv::IMREAD_GRAYSCALE);
  if (first.empty()) fail(left.front(), "is no image");
  const fs::path calib = folder / "calib.txt";
  const auto [P0, P1] = read_projections(calib);
  Dataset dataset;
  dataset.name = "kitti";
  dataset.trajectory_frame = "cam0";
  dataset.calibration = to_calibration(P0, P1, first.size(), calib);
  const auto times_s = read_times(folder / "times.txt", left.size());
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (left[i].filename() != right[i].filename()) fail(right[i], "has no partner in image_0");
    dataset.frames.push_back({kDatasetEpoch + from_seconds(times_s[i]), left[i], right[i]});
  }
  if (left.size() > 1) dataset.rate_hz = static_cast<double>(left.size() - 1) / (times_s[left.size() - 1] - times_s[0]);
  dataset.truth = read_poses(folder / "poses.txt", dataset.frames, dataset.calibration.T_body_left);
  return dataset;
}

}  // namespace arpent::tools
