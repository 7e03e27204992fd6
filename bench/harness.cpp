// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/harness.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "common/cpu_time.h"

namespace arpent::bench {
namespace {

/// Smoothed noise seen by two cameras with a slanted disparity: the reference needs an input that every machine has.
struct ReferencePair {
  static constexpr int kWidth = 640;
  static constexpr int kHeight = 512;
  static constexpr int kDisparities = 128;
  cv::Mat1b left;
  cv::Mat1b right;

  ReferencePair() {
    cv::Mat1b wide(kHeight, kWidth + kDisparities);
    cv::RNG rng(1);
    rng.fill(wide, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(wide, wide, cv::Size(5, 5), 1.2);
    cv::Mat1f map_x(kHeight, kWidth);
    cv::Mat1f map_y(kHeight, kWidth);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        map_x(v, u) = static_cast<float>(u) + 10.0F + 100.0F * static_cast<float>(v) / kHeight;
        map_y(v, u) = static_cast<float>(v);
      }
    }
    cv::remap(wide, right, map_x, map_y, cv::INTER_LINEAR);
    left = wide(cv::Rect(0, 0, kWidth, kHeight)).clone();
    cv::copyMakeBorder(left, left, 0, 0, kDisparities, 0, cv::BORDER_REPLICATE);
    cv::copyMakeBorder(right, right, 0, 0, kDisparities, 0, cv::BORDER_REPLICATE);
  }
};

}  // namespace

double cpu_ms(const std::function<void()>& work) {
  const double start = process_cpu_s();
  work();
  return 1e3 * (process_cpu_s() - start);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  if (n == 0) return 0;
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

double time_reference_once() {
  static const ReferencePair pair;
  cv::setNumThreads(1);
  const auto sgbm = cv::StereoSGBM::create(0, ReferencePair::kDisparities, 3, 8 * 3 * 3, 32 * 3 * 3, 1, 63, 10, 100, 32,
                                           cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat disparity;
  return cpu_ms([&] { sgbm->compute(pair.left, pair.right, disparity); });
}

void Report::add(const std::string& name, double value, const std::string& unit, const std::string& note) {
  rows_.push_back({name, value, unit, note});
  std::printf("%-44s %12.5g %-6s %s\n", name.c_str(), value, unit.c_str(), note.c_str());
  std::fflush(stdout);
}

double Report::add_time(const std::string& name, const std::function<void()>& work, int repetitions,
                        const std::string& note) {
  std::vector<double> subject;
  std::vector<double> reference;
  for (int i = 0; i < std::max(5, repetitions); ++i) {
    reference.push_back(time_reference_once());
    work();  // the reference has filled the caches with its own
    subject.push_back(cpu_ms(work));
  }
  const double ratio = median(subject) / median(reference);
  add(name, median(subject), "ms");
  add(name + "_over_ref", ratio, "1", note);
  return ratio;
}

std::string data_dir() {
  const char* dir = std::getenv("ARPENT_DATA");
  return dir != nullptr && std::filesystem::is_directory(dir) ? dir : "";
}

int run(int argc, char** argv, const std::string& title, const std::function<void(Report&)>& body) {
  CLI::App app{title};
  std::string json_file;
  app.add_option("--json", json_file, "write the figures as a flat JSON list of {name, value, unit}");
  CLI11_PARSE(app, argc, argv);
  Report report;
  try {
    body(report);
    std::vector<double> reference;
    for (int i = 0; i < 7; ++i) reference.push_back(time_reference_once());
    report.add("ref.sgbm_ms", median(reference), "ms");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench: %s\n", error.what());
    return 2;
  }
  if (json_file.empty()) return 0;
  nlohmann::json list = nlohmann::json::array();
  for (const Row& row : report.rows()) list.push_back({{"name", row.name}, {"value", row.value}, {"unit", row.unit}});
  std::ofstream out(json_file);
  out << list.dump(1) << '\n';
  if (!out.flush()) {
    std::fprintf(stderr, "bench: cannot write %s\n", json_file.c_str());
    return 2;
  }
  return 0;
}

}  // namespace arpent::bench
