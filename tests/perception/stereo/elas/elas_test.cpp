// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The whole matcher on pairs whose disparities are known exactly.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "perception/stereo/matcher.h"
#include "perception/stereo/noise.h"
#include "perception/stereo/remap.h"
#include "tests/perception/stereo/pictures.h"

namespace arpent::stereo {
namespace {

Disparities match(const cv::Mat1b& left, const cv::Mat1b& right, int range, int threads = 1) {
  MatcherParams params;
  params.algorithm = "elas";
  params.max_disparity_px = range;
  params.threads = threads;
  return make_matcher(params)->match(left, right);
}

/// A surface d(u, v) = d0 + a u + b v seen by the right camera, resampled from the left image.
struct Slanted {
  double d0, a, b;
  [[nodiscard]] double at(int u, int v) const { return d0 + a * u + b * v; }
  /// Right pixel u_r shows left pixel u with u - d(u, v) = u_r.
  [[nodiscard]] cv::Mat1b right_of(const cv::Mat1b& left) const {
    cv::Mat1f map_u(left.size()), map_v(left.size());
    for (int v = 0; v < left.rows; ++v) {
      for (int u = 0; u < left.cols; ++u) {
        map_u(v, u) = static_cast<float>((u + d0 + b * v) / (1 - a));
        map_v(v, u) = static_cast<float>(v);
      }
    }
    cv::Mat1b right;
    cv::remap(left, right, map_u, map_v, cv::INTER_CUBIC, cv::BORDER_REFLECT);
    return right;
  }
};

TEST(Elas, SlantedPlanesAreMeasuredToAFractionOfAPixel) {
  const cv::Mat1b left = texture(240, 480, 1);
  for (const Slanted& plane : {Slanted{20, 0, 0}, Slanted{30.4, 0.02, 0.05}, Slanted{10.7, -0.01, 0.15}}) {
    const Disparities d = match(left, plane.right_of(left), 128);
    int seen = 0, trusted = 0, off = 0;
    double squares = 0;
    for (int v = 4; v < left.rows - 4; ++v) {
      for (int u = 4; u < left.cols - 4; ++u) {
        if (u - plane.at(u, v) < 4) continue;
        ++seen;
        if (d.trusted(v, u) == kMissing) continue;
        ++trusted;
        const double error = d.trusted(v, u) / 128.0 - plane.at(u, v);
        off += std::abs(error) > 1 ? 1 : 0;
        squares += error * error;
      }
    }
    EXPECT_GT(trusted, seen * 95 / 100);
    EXPECT_LT(off, trusted / 500);
    EXPECT_LT(std::sqrt(squares / trusted), 0.25);
  }
}

TEST(Elas, DisparitiesReachThoseOfOurRigAtItsNearLimit) {
  const cv::Mat1b left = texture(120, 640, 2);
  const Slanted plane{318, 0, 0.05};
  const Disparities d = match(left, plane.right_of(left), 336);
  int trusted = 0, seen = 0;
  for (int v = 4; v < left.rows - 4; ++v) {
    for (int u = 335; u < left.cols - 4; ++u) {
      ++seen;
      if (d.trusted(v, u) == kMissing) continue;
      ++trusted;
      EXPECT_NEAR(d.trusted(v, u) / 128.0, plane.at(u, v), 1.0);
    }
  }
  EXPECT_GT(trusted, seen * 9 / 10);
}

TEST(Elas, ANearPostBeforeAWallKeepsBothSurfaces) {
  const cv::Mat1b wall = texture(240, 480, 3), post = texture(240, 480, 4);
  const Slanted wall_plane{10, 0, 0};
  cv::Mat1b left = wall.clone(), right = wall_plane.right_of(wall);
  const cv::Rect at(220, 0, 24, 240);
  post(at).copyTo(left(at));
  post(at).copyTo(right(at - cv::Point(60, 0)));
  const Disparities d = match(left, right, 96);
  int wall_right = 0, post_right = 0;
  for (int v = 8; v < 232; ++v) {
    for (int u = 224; u < 240; ++u) post_right += std::abs(d.filled(v, u) / 128.0 - 60) < 1 ? 1 : 0;
    for (int u = 260; u < 400; ++u) wall_right += std::abs(d.filled(v, u) / 128.0 - 10) < 1 ? 1 : 0;
  }
  EXPECT_GT(post_right, 224 * 16 * 97 / 100);
  EXPECT_GT(wall_right, 224 * 140 * 98 / 100);
}

TEST(Elas, NoDepthIsInventedOnAWallWithoutTextureHoweverNoisyTheCameras) {
  for (const double sigma : {0.5, 1.0, 2.0, 4.0, 8.0}) {
    cv::Mat1b pair[2];
    for (int k = 0; k < 2; ++k) {
      cv::Mat1s noise(256, 320);
      cv::RNG(static_cast<std::uint64_t>(k + 1)).fill(noise, cv::RNG::NORMAL, 90, sigma);
      noise.convertTo(pair[k], CV_8U);
    }
    const Disparities d = match(pair[0], pair[1], 96);
    EXPECT_LT(cv::countNonZero(d.trusted != kMissing), 256 * 320 / 100) << sigma;
  }
}

TEST(Elas, FaintTextureIsSeenThroughNoiseOfItsOwnStrength) {
  const cv::Mat1b strong = texture(256, 320, 1);
  cv::Mat1b faint;
  strong.convertTo(faint, CV_8U, 0.07, 80);  // deviation about 2.5 grey levels
  cv::Mat1b pair[2] = {faint, Slanted{12, 0, 0}.right_of(faint)};
  for (int k = 0; k < 2; ++k) {
    cv::Mat1s noise(faint.size());
    cv::RNG(static_cast<std::uint64_t>(k + 1)).fill(noise, cv::RNG::NORMAL, 0, 1.5);
    cv::add(pair[k], noise, pair[k], cv::noArray(), CV_8U);
  }
  const Disparities d = match(pair[0], pair[1], 64);
  int trusted = 0, right = 0;
  for (int v = 8; v < 248; ++v) {
    for (int u = 24; u < 312; ++u) {
      if (d.trusted(v, u) == kMissing) continue;
      ++trusted;
      right += std::abs(d.trusted(v, u) / 128.0 - 12) < 1 ? 1 : 0;
    }
  }
  EXPECT_GT(trusted, 240 * 288 / 2);
  EXPECT_GT(right, trusted * 93 / 100);
}

TEST(Elas, TheStatedDeviationFitsTheErrors) {
  const ArenaPair pair;
  const Disparities d = match(pair.left.image, pair.right.image, 128);
  std::vector<double> ratios;
  for (int v = 0; v < pair.camera.height_px; ++v) {
    for (int u = 0; u < pair.camera.width_px; ++u) {
      EXPECT_EQ(d.trusted(v, u) == kMissing, d.sigma_px(v, u) == 0.0F);
      if (d.trusted(v, u) == kMissing || pair.left.depth_m(v, u) <= 0) continue;
      ratios.push_back(std::abs(d.trusted(v, u) / 128.0 - pair.disparity_px(v, u)) / d.sigma_px(v, u));
    }
  }
  std::sort(ratios.begin(), ratios.end());
  const double at_68_percent = ratios[ratios.size() * 68 / 100];
  EXPECT_GT(at_68_percent, 0.4);
  EXPECT_LT(at_68_percent, 2.0);
}

TEST(Elas, TheSamePairGivesTheSameBytesWhateverCameBeforeAndWithAnyThreads) {
  const cv::Mat1b left = texture(97, 131, 5);
  const cv::Mat1b right = Slanted{12.3, 0.03, 0.02}.right_of(left);
  const Disparities expected = match(left, right, 48);
  for (const int threads : {1, 2, 5}) {
    MatcherParams params;
    params.max_disparity_px = 48;
    params.threads = threads;
    const auto matcher = make_matcher(params);
    (void)matcher->match(texture(97, 131, 6), texture(97, 131, 7));
    (void)matcher->match(texture(64, 200, 6), texture(64, 200, 7));
    const Disparities d = matcher->match(left, right);
    EXPECT_EQ(cv::norm(d.trusted, expected.trusted, cv::NORM_INF), 0) << threads;
    EXPECT_EQ(cv::norm(d.filled, expected.filled, cv::NORM_INF), 0) << threads;
    EXPECT_EQ(cv::norm(d.sigma_px, expected.sigma_px, cv::NORM_INF), 0) << threads;
  }
}

TEST(Noise, IsToldFromTheSmoothPartOfAnImage) {
  cv::Mat1b image(240, 320);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) image(v, u) = static_cast<std::uint8_t>(60 + u / 4 + v / 8);
  }
  texture(240, 160, 1).copyTo(image(cv::Rect(0, 0, 160, 240)));  // half of it is texture
  for (const double sigma : {3.0, 5.0, 8.0}) {
    cv::Mat1s noise(image.size());
    cv::RNG(2).fill(noise, cv::RNG::NORMAL, 0, sigma);
    cv::Mat1b noisy;
    cv::add(image, noise, noisy, cv::noArray(), CV_8U);
    EXPECT_GT(estimate_noise(noisy), 0.9 * sigma);
    EXPECT_LT(estimate_noise(noisy), 2.0 * sigma);
  }
  EXPECT_LT(estimate_noise(cv::Mat1b(50, 50, std::uint8_t{255})), 0.5);
}

TEST(Remap, AgreesWithOpenCvAndWithItsPlainTwin) {
  const cv::Mat1b image = texture(100, 131, 8);
  cv::Mat1f u(90, 117), v(90, 117);
  for (int row = 0; row < u.rows; ++row) {
    for (int col = 0; col < u.cols; ++col) {
      u(row, col) = 0.97F * static_cast<float>(col) + 0.1F * static_cast<float>(row) - 6;
      v(row, col) = 1.13F * static_cast<float>(row) - 0.05F * static_cast<float>(col) + 3;
    }
  }
  const Remap remap(u, v, image.size());
  cv::Mat1b wanted, difference;
  cv::remap(image, wanted, u, v, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  const cv::Mat1b result = remap.apply(image);
  cv::absdiff(result, wanted, difference);
  double worst = 0;
  cv::minMaxLoc(difference, nullptr, &worst);
  EXPECT_LE(worst, 4) << "positions are rounded to 1/32 px";
  EXPECT_LT(cv::mean(difference)[0], 0.3);
  EXPECT_EQ(cv::norm(result, remap.apply(image, true), cv::NORM_INF), 0);
  EXPECT_GT(cv::countNonZero(wanted == 0), 100) << "some of it lies outside";
}

TEST(Remap, AnUntouchedMapIsTheImage) {
  const cv::Mat1b image = texture(33, 47, 9);
  cv::Mat1f u(image.size()), v(image.size());
  for (int row = 0; row < u.rows; ++row) {
    for (int col = 0; col < u.cols; ++col) {
      u(row, col) = static_cast<float>(col);
      v(row, col) = static_cast<float>(row);
    }
  }
  EXPECT_EQ(cv::norm(Remap(u, v, image.size()).apply(image), image, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace arpent::stereo
