// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/edges.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/perception/tags/cube_pictures.h"

namespace arpent::tags {
namespace {

/// The grey of a pixel that a straight edge at distance d (positive: in the dark) crosses, blurred by a Gaussian: the
/// formula of an edge spread function.
double edge_spread(double d_px, double sigma_px) {
  return 20 + 180 * 0.5 * std::erfc(d_px / (std::sqrt(2.0) * sigma_px));
}

/// A dark square with the corners given, on white, with all its edges blurred; corners bottom left, bottom right, top
/// right, top left.
cv::Mat1b draw_square(const ImageCorners& corners, double sigma_px) {
  cv::Mat1b image(120, 120);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      double inside = 1e9;
      for (std::size_t k = 0; k < 4; ++k) {
        const Eigen::Vector2d along = (corners[(k + 1) % 4] - corners[k]).normalized();
        const Eigen::Vector2d inwards(along.y(), -along.x());
        inside = std::min(inside, inwards.dot(Eigen::Vector2d(u, v) - corners[k]));
      }
      image(v, u) = static_cast<std::uint8_t>(std::lround(edge_spread(inside, sigma_px)));
    }
  }
  return image;
}

ImageCorners turned_square(double angle_rad, double edge_px, const Eigen::Vector2d& centre) {
  ImageCorners corners;
  for (std::size_t k = 0; k < 4; ++k) {
    const double a = angle_rad + 0.75 * M_PI - static_cast<double>(k) * M_PI / 2;
    corners[k] = centre + edge_px / std::sqrt(2.0) * Eigen::Vector2d(std::cos(a), std::sin(a));
  }
  return corners;
}

ImageCorners displaced(ImageCorners corners, double by_px, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-by_px, by_px);
  for (auto& corner : corners) corner += Eigen::Vector2d(uniform(generator), uniform(generator));
  return corners;
}

TEST(TagEdges, SidesOfASquareLieWhereTheEdgeSpreadFunctionPutsThem) {
  for (unsigned i = 0; i < 60; ++i) {
    const ImageCorners truth = turned_square(0.05 * i, 44, {59.3 + 0.017 * i, 60.2 - 0.013 * i});
    const double sigma_px = i % 2 == 0 ? 0.5 : 1.0;
    const auto outline = fit_outline(draw_square(truth, sigma_px), displaced(truth, 0.8, i));
    ASSERT_TRUE(outline) << i;
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_LT((outline->corners_px[k] - truth[k]).norm(), 0.02) << i;
      const TagSide& side = outline->sides[k];
      EXPECT_NEAR(side.normal.norm(), 1, 1e-12);
      EXPECT_NEAR(side.normal.dot(truth[k]), side.offset_px, 0.02);
      EXPECT_NEAR(side.normal.dot(truth[(k + 1) % 4]), side.offset_px, 0.02);
      EXPECT_GT(side.normal.dot(truth[k] - truth[(k + 3) % 4]), 40) << "the normal points out of the square";
    }
  }
}

TEST(TagEdges, AShadeAcrossTheTagShiftsNothing) {
  const ImageCorners truth = turned_square(0.03, 44, {60, 60});
  cv::Mat1b image = draw_square(truth, 0.7);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      image(v, u) = cv::saturate_cast<std::uint8_t>(image(v, u) * (1.1 - 0.006 * u));  // to 40 % on the right
    }
  }
  const auto outline = fit_outline(image, displaced(truth, 0.5, 1));
  ASSERT_TRUE(outline);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_LT((outline->corners_px[k] - truth[k]).norm(), 0.05);
}

TEST(TagEdges, NoiseMovesTheSidesAsMuchAsTheCovarianceSays) {
  double squares = 0;
  int count = 0;
  for (unsigned i = 0; i < 200; ++i) {
    const ImageCorners truth = turned_square(0.11 + 0.031 * i, 40, {59.9, 60.4});
    cv::Mat1s noise(120, 120);
    cv::RNG rng(i + 1);
    rng.fill(noise, cv::RNG::NORMAL, 0, 8);
    cv::Mat1b noisy;
    cv::add(draw_square(truth, 0.7), noise, noisy, cv::noArray(), CV_8U);
    const auto outline = fit_outline(noisy, truth);
    ASSERT_TRUE(outline);
    for (std::size_t k = 0; k < 4; ++k) {
      const TagSide& side = outline->sides[k];
      const Eigen::Vector2d r(side.normal.dot(truth[k]) - side.offset_px,
                              side.normal.dot(truth[(k + 1) % 4]) - side.offset_px);
      squares += r.dot(side.covariance_px2.inverse() * r);
      count += 2;
    }
  }
  EXPECT_GT(squares / count, 0.6);
  EXPECT_LT(squares / count, 1.5);
}

TEST(TagEdges, RefusesWhatIsNoWholeSquare) {
  const ImageCorners truth = turned_square(0.1, 44, {60, 60});
  const cv::Mat1b image = draw_square(truth, 0.7);
  ASSERT_TRUE(fit_outline(image, truth));
  cv::Mat1b hidden = image.clone();
  hidden.colRange(0, 60).setTo(110);
  EXPECT_FALSE(fit_outline(hidden, truth)) << "half hidden";
  EXPECT_FALSE(fit_outline(255 - image, truth)) << "white on black";
  EXPECT_FALSE(fit_outline(cv::Mat1b(120, 120, std::uint8_t{90}), truth)) << "no contrast";
  EXPECT_FALSE(fit_outline(image(cv::Rect(0, 0, 80, 120)), truth)) << "partly outside";
  const ImageCorners small = turned_square(0.1, 11, {60, 60});
  EXPECT_FALSE(fit_outline(draw_square(small, 0.5), small)) << "cells of 1.4 pixels";
  const ImageCorners flat{Eigen::Vector2d(10, 60), {50, 60}, {90, 60}, {30, 60}};
  EXPECT_FALSE(fit_outline(image, flat)) << "no area";
}

}  // namespace
}  // namespace arpent::tags
