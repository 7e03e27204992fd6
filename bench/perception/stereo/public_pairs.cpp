// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/perception/stereo/public_pairs.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/error.h"
#include "perception/stereo/depth_map.h"

namespace arpent::bench {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::infinity();

cv::Mat1b read_grey(const std::string& file) {
  cv::Mat1b image = cv::imread(file, cv::IMREAD_GRAYSCALE);
  if (image.empty()) throw InputError(file + ": cannot be read as an image");
  return image;
}

/// Disparity times `scale` in 8 bits, 0 unknown.
cv::Mat1f read_scaled_truth(const std::string& file, double scale) {
  const cv::Mat1b image = read_grey(file);
  cv::Mat1f truth;
  image.convertTo(truth, CV_32F, 1.0 / scale);
  truth.setTo(kUnknown, image == 0);
  return truth;
}

/// Rows from the bottom up; the header's scale is not applied (SOURCES.txt).
cv::Mat1f read_pfm(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string magic;
  int width = 0, height = 0;
  double scale = 0;
  if (!(in >> magic >> width >> height >> scale) || magic != "Pf") throw InputError(file + ": not a PFM image");
  in.get();
  cv::Mat1f image(height, width);
  for (int v = height - 1; v >= 0; --v) {
    in.read(reinterpret_cast<char*>(image[v]), static_cast<std::streamsize>(sizeof(float)) * width);
  }
  if (!in) throw InputError(file + ": ends too early");
  return image;
}

cv::Mat1b known(const cv::Mat1f& truth) {
  return truth < 1e6;
}

/// Seen by both cameras: the truths of both views agree to a pixel.
cv::Mat1b agreeing(const cv::Mat1f& left, const cv::Mat1f& right) {
  cv::Mat1b mask(left.size(), std::uint8_t{0});
  for (int v = 0; v < left.rows; ++v) {
    for (int u = 0; u < left.cols; ++u) {
      if (!std::isfinite(left(v, u))) continue;
      const int partner = static_cast<int>(std::lround(static_cast<float>(u) - left(v, u)));
      if (partner >= 0 && std::abs(right(v, partner) - left(v, u)) <= 1) mask(v, u) = 255;
    }
  }
  return mask;
}

PublicPair load_version2(const std::string& folder, const std::string& name, double scale, int range_px) {
  const std::string dir = folder + "/" + name + "/";
  PublicPair pair{name,
                  read_grey(dir + "imL.png"),
                  read_grey(dir + "imR.png"),
                  read_scaled_truth(dir + "groundtruth.png", scale),
                  {},
                  range_px};
  pair.evaluated = (read_grey(dir + "nonocc.png") == 255) & known(pair.truth_px);
  return pair;
}

PublicPair load_half_size(const std::string& folder, const std::string& name, int range_px) {
  const std::string dir = folder + "/" + name + "/";
  PublicPair pair{
      name,    read_grey(dir + "view1.png"), read_grey(dir + "view5.png"), read_scaled_truth(dir + "disp1.png", 2), {},
      range_px};
  pair.evaluated = agreeing(pair.truth_px, read_scaled_truth(dir + "disp5.png", 2));
  return pair;
}

PublicPair load_pfm(const std::string& dir, const std::string& name, const std::string& mask, int range_px) {
  PublicPair pair{name,
                  read_grey(dir + "im0.png"),
                  read_grey(dir + "im1.png"),
                  read_pfm(dir + (mask.empty() ? "disp0.pfm" : "disp0GT.pfm")),
                  {},
                  range_px};
  pair.evaluated = known(pair.truth_px);
  if (!mask.empty()) pair.evaluated &= read_grey(dir + mask) == 255;
  return pair;
}

}  // namespace

std::vector<PublicPair> load_public_pairs(const std::string& data_dir) {
  const std::string folder = data_dir + "/stereo/pairs";
  return {load_version2(folder, "teddy", 4, 64),
          load_version2(folder, "venus", 8, 32),
          load_half_size(folder, "Reindeer", 112),
          load_half_size(folder, "Cloth3", 96),
          load_pfm(folder + "/MotorcycleQ/", "MotorcycleQ", "mask0nocc.png", 80),
          load_pfm(folder + "/eth3d_terrace/", "terrace", "", 32)};
}

PublicPair scaled(const PublicPair& pair, const cv::Size& size, int range_px) {
  PublicPair out{pair.name, {}, {}, {}, {}, range_px};
  cv::resize(pair.left, out.left, size, 0, 0, cv::INTER_AREA);
  cv::resize(pair.right, out.right, size, 0, 0, cv::INTER_AREA);
  cv::resize(pair.truth_px, out.truth_px, size, 0, 0, cv::INTER_NEAREST);
  out.truth_px *= static_cast<double>(size.width) / pair.left.cols;
  cv::resize(pair.evaluated, out.evaluated, size, 0, 0, cv::INTER_NEAREST);
  return out;
}

PublicPair cropped(const PublicPair& pair, const cv::Rect& rect, int range_px) {
  return {pair.name,
          pair.left(rect).clone(),
          pair.right(rect).clone(),
          pair.truth_px(rect).clone(),
          pair.evaluated(rect).clone(),
          range_px};
}

PublicPair with_noise(const PublicPair& pair, double sigma, std::uint64_t seed) {
  PublicPair out = pair;
  cv::RNG rng(seed);
  for (cv::Mat1b* image : {&out.left, &out.right}) {
    cv::Mat1s noise(image->size());
    rng.fill(noise, cv::RNG::NORMAL, 0, sigma);
    cv::Mat1b noisy;
    cv::add(*image, noise, noisy, cv::noArray(), CV_8U);
    *image = noisy;
  }
  return out;
}

Score score(const PublicPair& pair, const cv::Mat1w& px128) {
  double evaluated = 0, estimated = 0, wrong = 0, sum = 0;
  for (int v = 0; v < px128.rows; ++v) {
    for (int u = 0; u < px128.cols; ++u) {
      if (pair.evaluated(v, u) == 0) continue;
      ++evaluated;
      if (px128(v, u) == stereo::kMissing) continue;
      ++estimated;
      const double error = std::abs(px128(v, u) / stereo::kUnitsPerPixel - pair.truth_px(v, u));
      sum += error;
      if (error > 2) ++wrong;
    }
  }
  const double missing = evaluated - estimated;
  return {100 * estimated / evaluated, 100 * (wrong + missing) / evaluated, 100 * wrong / std::max(estimated, 1.0),
          sum / std::max(estimated, 1.0)};
}

}  // namespace arpent::bench
