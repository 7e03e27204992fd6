// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent depth LEFT RIGHT`: the disparity of one stereo pair, as a float PFM.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "common/atomic_file.h"
#include "common/error.h"
#include "perception/stereo/calibration_file.h"
#include "perception/stereo/matcher.h"
#include "perception/stereo/rectifier.h"
#include "tools/report/html.h"

namespace {

using namespace arpent;

cv::Mat1b load(const std::string& file) {
  cv::Mat1b image = cv::imread(file, cv::IMREAD_GRAYSCALE);
  if (image.empty()) throw InputError(file + ": cannot be read as an image");
  return image;
}

/// Pixels; missing is infinite.
cv::Mat1f to_float(const cv::Mat1w& px128) {
  cv::Mat1f disparity;
  px128.convertTo(disparity, CV_32F, 1.0 / stereo::kUnitsPerPixel);
  disparity.setTo(std::numeric_limits<float>::infinity(), px128 == stereo::kMissing);
  return disparity;
}

/// PFM: rows from the bottom up, little-endian (scale -1).
void write_pfm(const std::string& file, const cv::Mat1f& image) {
  atomic_write(file, [&](const WriteBytes& write) {
    const std::string header = "Pf\n" + std::to_string(image.cols) + " " + std::to_string(image.rows) + "\n-1.0\n";
    write(std::as_bytes(std::span(header)));
    for (int v = image.rows - 1; v >= 0; --v) {
      write(std::as_bytes(std::span(image.ptr<float>(v), static_cast<std::size_t>(image.cols))));
    }
  });
}

struct Flags {
  std::string left, right, output = "trusted", out, calibration, preview;
  stereo::MatcherParams matcher;
};

int run(const Flags& flags) {
  cv::setNumThreads(1);
  cv::Mat1b left = load(flags.left), right = load(flags.right);
  if (left.size() != right.size()) throw InputError("the images differ in size: " + flags.left + ", " + flags.right);
  if (left.cols < 32 || left.rows < 32) throw InputError("the images are smaller than 32 x 32 pixels");
  if (!flags.calibration.empty()) {
    const StereoCalibration calibration = stereo::read_calibration(flags.calibration, left.cols, left.rows);
    if (calibration.left.pinhole.width_px != left.cols || calibration.left.pinhole.height_px != left.rows) {
      throw InputError(flags.calibration + ": is for images of another size");
    }
    std::tie(left, right) = stereo::Rectifier(calibration).rectify(left, right);
  }
  const auto matcher = stereo::make_matcher(flags.matcher);
  const auto start = std::chrono::steady_clock::now();
  const stereo::Disparities disparities = matcher->match(left, right);
  const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
  const cv::Mat1w& chosen = flags.output == "filled" ? disparities.filled : disparities.trusted;
  write_pfm(flags.out, to_float(chosen));
  if (!flags.preview.empty()) {
    cv::Mat1f shown = to_float(chosen);
    shown.setTo(0, chosen == stereo::kMissing);
    cv::imwrite(flags.preview, report::colour(shown, 0, flags.matcher.max_disparity_px));
  }
  const double density = 100.0 * cv::countNonZero(chosen != stereo::kMissing) / static_cast<double>(chosen.total());
  std::printf("%s: %.1f ms, %.1f %% of the pixels, vertical offset %.2f px\n", flags.out.c_str(), elapsed.count(),
              density, disparities.vertical_offset_px);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Disparity of a rectified stereo pair (or of a raw one, with --calibration)."};
  app.name("arpent depth");
  Flags flags;
  app.add_option("LEFT", flags.left, "left image")->required();
  app.add_option("RIGHT", flags.right, "right image")->required();
  app.add_option("--max-disparity", flags.matcher.max_disparity_px, "disparities searched [px]")
      ->capture_default_str()
      ->check(CLI::Range(16, 511));
  app.add_option("--output", flags.output,
                 "trusted: missing means missing; filled: a value wherever anything can be said")
      ->capture_default_str()
      ->check(CLI::IsMember({"filled", "trusted"}));
  app.add_option("--out", flags.out, "disparity image to write: float PFM, bottom-up, little-endian, missing = inf")
      ->required();
  app.add_option("--algorithm", flags.matcher.algorithm, "matcher")->capture_default_str();
  app.add_option("--calibration", flags.calibration, "rectify first: Kalibr camchain, OpenCV YAML or a rig file");
  app.add_option("--threads", flags.matcher.threads, "threads")->check(CLI::Range(1, 16));
  app.add_option("--preview", flags.preview, "write a coloured picture as well (PNG)");
  try {
    app.parse(argc, argv);
    return run(flags);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "depth: %s\n", error.what());
    return 2;
  }
}
