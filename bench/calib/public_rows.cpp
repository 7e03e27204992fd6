// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <fstream>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>

#include "bench/calib/rows.h"
#include "calib/initial.h"
#include "calib/stereo.h"
#include "common/error.h"
#include "perception/tags/detector.h"

namespace arpent::bench {
namespace {

namespace fs = std::filesystem;
using calib::BoardViews;

constexpr int kViewNumbers[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 13, 14};

BoardViews detect_chessboards(const fs::path& folder) {
  calib::Target target;
  target.kind = calib::TargetKind::kChessboard;
  target.rows = 6;
  target.columns = 9;
  target.row_m = target.column_m = 1;
  const calib::BoardDetector detector(target);
  BoardViews views{target, {{"left", 640, 480}, {"right", 640, 480}}, {}};
  for (const int number : kViewNumbers) {
    char name[16];
    std::snprintf(name, sizeof name, "%02d.jpg", number);
    calib::View view{name, {}};
    for (const char* side : {"left", "right"}) {
      view.cameras.push_back(
          detector.detect(cv::imread((folder / (side + std::string(name))).string(), cv::IMREAD_GRAYSCALE)));
      if (view.cameras.back().empty()) throw InputError(folder.string() + ": no board in " + side + name);
    }
    views.views.push_back(view);
  }
  return views;
}

/// OpenCV's stereo calibration with k1, k2, p1, p2: each camera first, then the pair.
calib::RigEstimate calibrate_by_opencv(const BoardViews& views) {
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> px[2];
  for (const auto& view : views.views) {
    auto& points = board.emplace_back();
    for (std::size_t c = 0; c < 2; ++c) {
      auto& list = px[c].emplace_back();
      for (const auto& corner : view.cameras[c]) {
        list.emplace_back(static_cast<float>(corner.px.x()), static_cast<float>(corner.px.y()));
        if (c > 0) continue;
        const Eigen::Vector2d b = views.target.corner_m(corner.index);
        points.emplace_back(static_cast<float>(b.x()), static_cast<float>(b.y()), 0.0F);
      }
    }
  }
  const cv::Size size(views.cameras[0].width_px, views.cameras[0].height_px);
  const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 200, 1e-10);
  cv::Mat K[2], D[2], R, t, E, F;
  for (std::size_t c = 0; c < 2; ++c) {
    std::vector<cv::Mat> w, s;
    cv::calibrateCamera(board, px[c], size, K[c], D[c], w, s, cv::CALIB_FIX_K3, until);
  }
  cv::stereoCalibrate(board, px[0], px[1], K[0], D[0], K[1], D[1], size, R, t, E, F,
                      cv::CALIB_USE_INTRINSIC_GUESS | cv::CALIB_FIX_K3, until);
  calib::RigEstimate rig{std::vector<RawCamera>(2), std::vector<Pose>(2, Pose::Identity()), {}};
  for (std::size_t c = 0; c < 2; ++c) {
    const cv::Mat1d k = K[c], d = D[c].reshape(1, 1);
    rig.cameras[c].pinhole = {size.width, size.height, k(0, 0), k(1, 1), k(0, 2), k(1, 2)};
    rig.cameras[c].distortion = DistortionModel::kRadialTangential;
    rig.cameras[c].coefficients = {d(0), d(1), d(2), d(3), 0};
  }
  for (int r = 0; r < 3; ++r) {
    for (int col = 0; col < 3; ++col) rig.T_cam_first[1].matrix()(r, col) = R.at<double>(r, col);
    rig.T_cam_first[1].matrix()(r, 3) = t.at<double>(r);
  }
  return rig;
}

/// The views whose number is even, or odd.
BoardViews half(const BoardViews& views, std::size_t parity) {
  BoardViews part{views.target, views.cameras, {}};
  for (std::size_t v = parity; v < views.views.size(); v += 2) part.views.push_back(views.views[v]);
  return part;
}

calib::RigEstimate calibrate_by_us(const BoardViews& views) {
  calib::CalibrationParams params;
  params.reject_outliers = false;  // the same corners for both
  return calib::calibrate(views, params).rig;
}

struct TagCount {
  int expected = 0;
  int found = 0;
};

TagCount count_tags(const calib::BoardDetector& detector, const fs::path& image, const fs::path& csv) {
  std::set<int> found;
  for (const auto& corner : detector.detect(cv::imread(image.string(), cv::IMREAD_GRAYSCALE)))
    found.insert(corner.index / 4);
  std::set<int> expected;
  std::ifstream in(csv);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    double value = 0;
    for (int column = 0; column <= 10; ++column) row >> value;
    expected.insert(static_cast<int>(value));
  }
  TagCount count{static_cast<int>(expected.size()), 0};
  for (const int tag : expected) count.found += found.contains(tag);
  return count;
}

}  // namespace

void add_chessboard_rows(Report& report, const fs::path& folder) {
  const BoardViews views = detect_chessboards(folder);
  const double ours_px = calib::rms_of_other_views(calibrate_by_us(views), views);
  const double theirs_px = calib::rms_of_other_views(calibrate_by_opencv(views), views);
  report.add("calib.rms_px", ours_px, "px", "13 pairs of OpenCV's chessboard set");
  report.add("calib.rms_opencv_px", theirs_px, "px");
  report.add("calib.rms_ratio_to_opencv", ours_px / theirs_px, "1", "bar <= 1.0");
  double ours2 = 0, theirs2 = 0;
  for (const std::size_t parity : {0U, 1U}) {
    const BoardViews fit = half(views, parity), held_out = half(views, 1 - parity);
    const auto n = static_cast<double>(held_out.views.size());
    ours2 += n * std::pow(calib::rms_of_other_views(calibrate_by_us(fit), held_out), 2);
    theirs2 += n * std::pow(calib::rms_of_other_views(calibrate_by_opencv(fit), held_out), 2);
  }
  report.add("calib.holdout_ratio_to_opencv", std::sqrt(ours2 / theirs2), "1",
             "bar <= 1.02; halves predict each other");
}

void add_apriltag_rows(Report& report, const fs::path& folder) {
  calib::Target target;
  const calib::BoardDetector detector(target);
  TagCount sum;
  std::vector<fs::path> csvs;
  for (const auto& entry : fs::directory_iterator(folder / "yac_mocap/grid0/cam0/data")) csvs.push_back(entry.path());
  for (const fs::path& csv : csvs) {
    const auto count = count_tags(detector, folder / "yac_mocap/cam0/data" / (csv.stem().string() + ".jpg"), csv);
    sum.expected += count.expected;
    sum.found += count.found;
  }
  report.add("calib.aprilgrid_found_percent", 100.0 * sum.found / sum.expected, "%", "bar >= 95; 2-bit border");
  tags::DetectorParams params;
  params.decimate = 1;
  params.max_hamming = 2;
  params.min_decision_margin = 0;
  const tags::TagDetector tag_detector(params);
  int found = 0, wrong = 0;
  for (const auto& entry : fs::directory_iterator(folder / "aprilrobotics")) {
    if (entry.path().extension() != ".txt") continue;
    std::multiset<int> expected;
    std::ifstream in(entry.path());
    for (std::string line; std::getline(in, line);) {
      std::replace(line.begin(), line.end(), ',', ' ');
      if (int id = 0; std::istringstream(line) >> id) expected.insert(id);
    }
    const auto image = fs::path(entry.path()).replace_extension(".jpg");
    for (const auto& tag : tag_detector.detect(cv::imread(image.string(), cv::IMREAD_GRAYSCALE))) {
      const auto at = expected.find(tag.id);
      at == expected.end() ? ++wrong : ++found;
      if (at != expected.end()) expected.erase(at);
    }
  }
  report.add("calib.apriltag_found", found, "1", "bar 47, the library's three photos");
  report.add("calib.apriltag_false", wrong, "1", "bar 0");
}

}  // namespace arpent::bench
