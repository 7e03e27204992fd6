// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <set>

#include "common/error.h"
#include "common/split.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using calib::BoardViews;
using Files = std::map<std::string, fs::path>;

bool has_extension(const fs::path& file, const std::vector<std::string>& extensions) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

Files files_in(const fs::path& folder, const std::vector<std::string>& extensions) {
  Files files;
  const fs::path data = folder / "data";
  for (const auto& entry : fs::directory_iterator(fs::is_directory(data) ? data : folder)) {
    if (entry.is_regular_file() && has_extension(entry.path(), extensions))
      files[entry.path().stem().string()] = entry.path();
  }
  return files;
}

using Row = std::map<std::string, double>;

std::vector<Row> read_csv(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line)) throw InputError(file.string() + ": is empty or cannot be read");
  const auto cells_of = [](const std::string& text) {
    std::vector<std::string> cells;
    for (std::string& cell : split(text.starts_with("#") ? text.substr(1) : text, ',')) {
      cell.erase(std::remove_if(cell.begin(), cell.end(), [](unsigned char c) { return std::isspace(c); }), cell.end());
      cells.push_back(cell);
    }
    return cells;
  };
  const auto names = cells_of(line);
  for (const char* needed : {"kp_x", "kp_y", "p_x", "p_y", "p_z"}) {
    if (std::find(names.begin(), names.end(), needed) == names.end()) {
      throw InputError(fmt::format("{}: has no column {}", file.string(), needed));
    }
  }
  std::vector<Row> rows;
  for (int number = 2; std::getline(in, line); ++number) {
    if (line.empty()) continue;
    const auto cells = cells_of(line);
    Row row;
    for (std::size_t i = 0; i < std::min(names.size(), cells.size()); ++i) {
      try {
        row[names[i]] = std::stod(cells[i]);
      } catch (const std::exception&) {
        throw InputError(fmt::format("{}:{}: '{}' is no number", file.string(), number, cells[i]));
      }
    }
    if (cells.size() < names.size()) throw InputError(fmt::format("{}:{}: has too few columns", file.string(), number));
    rows.push_back(row);
  }
  return rows;
}

/// Which corner of the board is at a place.
int corner_at(const calib::Target& target, const Eigen::Vector2d& place_m, const fs::path& file) {
  int nearest = 0;
  double least_m = 1e9;
  for (int i = 0; i < target.corner_count(); ++i) {
    const double d_m = (target.corner_m(i) - place_m).norm();
    if (d_m < least_m) least_m = d_m, nearest = i;
  }
  const double side_m =
      target.kind == calib::TargetKind::kAprilGrid ? target.tag_m : std::min(target.row_m, target.column_m);
  if (least_m > 0.01 * side_m) {
    throw InputError(
        fmt::format("{}: the corner at ({:g}, {:g}) m is not on the board of the target file, whose nearest is {:.1f} "
                    "mm away: wrong size or spacing?",
                    file.string(), place_m.x(), place_m.y(), 1e3 * least_m));
  }
  return nearest;
}

calib::Corners read_corners(const calib::Target& target, const fs::path& file) {
  calib::Corners corners;
  for (Row& row : read_csv(file)) {
    if (std::abs(row["p_z"]) > 1e-6) throw InputError(file.string() + ": p_z must be 0: boards are flat");
    corners.push_back({corner_at(target, {row["p_x"], row["p_y"]}, file), {row["kp_x"], row["kp_y"]}});
  }
  std::sort(corners.begin(), corners.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
  for (std::size_t i = 1; i < corners.size(); ++i) {
    if (corners[i].index == corners[i - 1].index) throw InputError(file.string() + ": names a corner twice");
  }
  return corners;
}

std::array<int, 2> usual_size(const BoardViews& views) {
  static constexpr std::array<int, 2> kSizes[] = {{640, 480},   {640, 512},   {752, 480},   {1280, 720},
                                                  {1280, 800},  {1280, 960},  {1280, 1024}, {1600, 1200},
                                                  {1920, 1080}, {1920, 1200}, {2048, 1536}, {4096, 3072}};
  Eigen::Vector2d most(0, 0);
  for (const auto& view : views.views) {
    for (const auto& corners : view.cameras) {
      for (const auto& corner : corners) most = most.cwiseMax(corner.px);
    }
  }
  for (const auto& size : kSizes) {
    if (most.x() < size[0] && most.y() < size[1]) return size;
  }
  throw InputError("the corners lie outside every usual image: state the size with --size");
}

/// Views by name, in order; cameras without a file in a view have no corners.
BoardViews empty_views(const calib::Target& target, const std::map<std::string, Files>& cameras) {
  BoardViews views{target, {}, {}};
  std::set<std::string> names;
  for (const auto& [camera, files] : cameras) {
    views.cameras.push_back({camera, 0, 0});
    for (const auto& [name, file] : files) names.insert(name);
  }
  for (const std::string& name : names) views.views.push_back({name, std::vector<calib::Corners>(cameras.size())});
  return views;
}

void note_size(calib::CameraInput& camera, const cv::Mat& image, const fs::path& file) {
  if (camera.width_px == 0) camera.width_px = image.cols, camera.height_px = image.rows;
  if (camera.width_px != image.cols || camera.height_px != image.rows) {
    throw InputError(fmt::format("mixed sizes: {} is {} x {}, the other pictures of {} are {} x {}", file.string(),
                                 image.cols, image.rows, camera.name, camera.width_px, camera.height_px));
  }
}

}  // namespace

std::map<std::string, Files> find_camera_files(const fs::path& given, const std::vector<std::string>& extensions) {
  if (!fs::is_directory(given)) throw InputError(given.string() + ": is no folder");
  const fs::path folder = fs::is_directory(given / "mav0") ? given / "mav0" : given;
  static const std::regex camera_name("(left|right|cam[0-9]+)[_-]?(.*)");
  std::map<std::string, Files> cameras;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    std::smatch parts;
    if (!entry.is_directory() || !std::regex_match(name, parts, camera_name) || !parts[2].str().empty()) continue;
    if (auto files = files_in(entry.path(), extensions); !files.empty()) cameras[name] = std::move(files);
  }
  if (!cameras.empty()) return cameras;
  const Files flat = files_in(folder, extensions);
  for (const auto& [name, file] : flat) {
    std::smatch parts;
    if (std::regex_match(name, parts, camera_name)) cameras[parts[1].str()][parts[2].str()] = file;
  }
  if (cameras.empty() && !flat.empty()) cameras["cam0"] = flat;
  if (cameras.empty())
    throw InputError(fmt::format("{}: has no {} files", folder.string(), fmt::join(extensions, ", ")));
  return cameras;
}

BoardViews views_from_images(const calib::Target& target, const fs::path& folder, const Progress& progress) {
  const auto cameras = find_camera_files(folder, {".png", ".jpg", ".jpeg", ".pgm", ".bmp", ".tif", ".tiff"});
  BoardViews views = empty_views(target, cameras);
  const calib::BoardDetector detector(target);
  std::size_t c = 0;
  const std::size_t total = views.views.size() * cameras.size();
  for (const auto& [name, files] : cameras) {
    for (std::size_t v = 0; v < views.views.size(); ++v) {
      progress(c * views.views.size() + v + 1, total);
      const auto file = files.find(views.views[v].name);
      if (file == files.end()) continue;
      const cv::Mat1b image = cv::imread(file->second.string(), cv::IMREAD_GRAYSCALE);
      if (image.empty()) throw InputError(file->second.string() + ": cannot be read as an image");
      note_size(views.cameras[c], image, file->second);
      views.views[v].cameras[c] = detector.detect(image);
    }
    ++c;
  }
  return views;
}

BoardViews views_from_corners(const calib::Target& target, const fs::path& folder, std::array<int, 2> size) {
  const auto cameras = find_camera_files(folder, {".csv"});
  BoardViews views = empty_views(target, cameras);
  std::size_t c = 0;
  for (const auto& [name, files] : cameras) {
    for (auto& view : views.views) {
      if (const auto file = files.find(view.name); file != files.end())
        view.cameras[c] = read_corners(target, file->second);
    }
    ++c;
  }
  if (size[0] == 0) size = usual_size(views);
  for (auto& camera : views.cameras) camera.width_px = size[0], camera.height_px = size[1];
  return views;
}

}  // namespace arpent::tools
