// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/calibration_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <opencv2/core.hpp>

#include "common/config/rig.h"
#include "common/error.h"

namespace arpent::stereo {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw InputError(fmt::format("{}: {}", file.string(), what));
}

StereoCalibration checked(const StereoCalibration& calibration, const fs::path& file) {
  const auto faults = find_faults(calibration);
  if (!faults.empty()) fail(file, fmt::format("{}", fmt::join(faults, "; ")));
  return calibration;
}

std::string first_text(const fs::path& file) {
  std::ifstream in(file);
  std::string text(4096, '\0');
  if (fs::is_directory(file) || !in) fail(file, "cannot be read");
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

RawCamera kalibr_camera(const YAML::Node& node, const fs::path& file) {
  if (!node) fail(file, "has no cam0 and cam1");
  if (const auto model = node["camera_model"].as<std::string>(); model != "pinhole") {
    fail(file, "camera_model must be pinhole, not " + model);
  }
  const auto intrinsics = node["intrinsics"].as<std::vector<double>>();
  const auto size = node["resolution"].as<std::vector<int>>();
  const auto coefficients = node["distortion_coeffs"].as<std::vector<double>>();
  const auto model = node["distortion_model"].as<std::string>();
  if (intrinsics.size() != 4 || size.size() != 2) fail(file, "intrinsics must be 4 numbers and resolution 2");
  RawCamera camera;
  camera.pinhole = {size[0], size[1], intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]};
  if (model == "radtan") {
    camera.distortion = DistortionModel::kRadialTangential;
  } else if (model == "equidistant") {
    camera.distortion = DistortionModel::kEquidistant;
  } else if (model != "none") {
    fail(file, "distortion_model must be radtan, equidistant or none, not " + model);
  }
  if (model != "none" && coefficients.size() != 4) fail(file, "distortion_coeffs must be 4 numbers");
  if (model != "none") std::copy(coefficients.begin(), coefficients.end(), camera.coefficients.begin());
  return camera;
}

cv::Mat1d read_matrix(const std::vector<cv::FileStorage>& stores, std::initializer_list<const char*> names, int rows,
                      int cols, const fs::path& file) {
  for (const cv::FileStorage& store : stores) {
    for (const char* name : names) {
      cv::Mat matrix;
      if (store[name].isMap()) store[name] >> matrix;
      if (matrix.empty()) continue;
      matrix.convertTo(matrix, CV_64F);
      if (rows > 0 && (matrix.rows != rows || matrix.cols != cols)) {
        fail(file, fmt::format("{} must be {} x {}", name, rows, cols));
      }
      return matrix;
    }
  }
  fail(file, fmt::format("has no {}", *names.begin()));
}

/// OpenCV's own files name no model: theirs is the radial-tangential one.
DistortionModel opencv_model(const std::vector<cv::FileStorage>& stores, const fs::path& file) {
  for (const cv::FileStorage& store : stores) {
    if (store["distortion_model"].empty()) continue;
    const std::string name = store["distortion_model"];
    if (name == "equidistant") return DistortionModel::kEquidistant;
    if (name != "radtan") fail(file, "distortion_model must be radtan or equidistant, not " + name);
  }
  return DistortionModel::kRadialTangential;
}

RawCamera opencv_camera(const cv::Mat1d& K, const cv::Mat1d& D, DistortionModel model, int width_px, int height_px,
                        const fs::path& file) {
  RawCamera camera;
  camera.pinhole = {width_px, height_px, K(0, 0), K(1, 1), K(0, 2), K(1, 2)};
  camera.distortion = model;
  const int most = model == DistortionModel::kEquidistant ? 4 : 5;
  const cv::Mat1d flat = D.reshape(1, 1);
  for (int i = 0; i < flat.cols; ++i) {
    if (i < most) {
      camera.coefficients[static_cast<std::size_t>(i)] = flat(i);
    } else if (flat(i) != 0) {
      fail(file, fmt::format("more than {} distortion coefficients are not supported", most));
    }
  }
  return camera;
}

}  // namespace

StereoCalibration read_kalibr_camchain(const fs::path& file) {
  try {
    const YAML::Node root = YAML::LoadFile(file.string());
    StereoCalibration calibration;
    calibration.left = kalibr_camera(root["cam0"], file);
    calibration.right = kalibr_camera(root["cam1"], file);
    const auto rows = root["cam1"]["T_cn_cnm1"].as<std::vector<std::vector<double>>>();
    if (rows.size() < 3) fail(file, "T_cn_cnm1 of cam1 must be a 4 x 4 matrix");
    for (int r = 0; r < 3; ++r) {
      const auto& row = rows[static_cast<std::size_t>(r)];
      if (row.size() != 4) fail(file, "T_cn_cnm1 of cam1 must be a 4 x 4 matrix");
      for (int c = 0; c < 4; ++c) calibration.T_right_left.matrix()(r, c) = row[static_cast<std::size_t>(c)];
    }
    return checked(calibration, file);
  } catch (const YAML::Exception& error) {
    fail(file, fmt::format("line {}: {}", error.mark.line + 1, error.msg));
  }
}

StereoCalibration read_opencv_calibration(const std::vector<fs::path>& files, int width_px, int height_px) {
  const fs::path& file = files.front();
  try {
    std::vector<cv::FileStorage> stores;
    for (const fs::path& path : files) {
      stores.emplace_back(path.string(), cv::FileStorage::READ);
      if (!stores.back().isOpened()) fail(path, "cannot be read");
    }
    for (const cv::FileStorage& store : stores) {
      if (!store["image_width"].empty()) width_px = static_cast<int>(store["image_width"]);
      if (!store["image_height"].empty()) height_px = static_cast<int>(store["image_height"]);
    }
    if (width_px <= 0 || height_px <= 0) fail(file, "does not state the image size: image_width, image_height");
    const DistortionModel model = opencv_model(stores, file);
    StereoCalibration calibration;
    calibration.left =
        opencv_camera(read_matrix(stores, {"M1", "cameraMatrix1", "K1"}, 3, 3, file),
                      read_matrix(stores, {"D1", "distCoeffs1"}, 0, 0, file), model, width_px, height_px, file);
    calibration.right =
        opencv_camera(read_matrix(stores, {"M2", "cameraMatrix2", "K2"}, 3, 3, file),
                      read_matrix(stores, {"D2", "distCoeffs2"}, 0, 0, file), model, width_px, height_px, file);
    const cv::Mat1d R = read_matrix(stores, {"R"}, 3, 3, file);
    const cv::Mat1d T = read_matrix(stores, {"T"}, 0, 0, file).reshape(1, 3);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) calibration.T_right_left.matrix()(r, c) = R(r, c);
      calibration.T_right_left.matrix()(r, 3) = T(r);
    }
    return checked(calibration, file);
  } catch (const cv::Exception& error) {
    fail(file, "is no OpenCV calibration: " + error.err);
  }
}

StereoCalibration read_calibration(const fs::path& file, int width_px, int height_px) {
  const std::string text = first_text(file);
  if (text.find("cam0:") != std::string::npos) return read_kalibr_camchain(file);
  if (text.find("%YAML") != std::string::npos || text.find("<opencv_storage>") != std::string::npos) {
    return read_opencv_calibration({file}, width_px, height_px);
  }
  return load_rig(file).calibration;
}

}  // namespace arpent::stereo
