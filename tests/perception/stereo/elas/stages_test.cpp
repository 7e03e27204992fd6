// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The stages of the matcher, each against brute force: descriptors, lane arithmetic, narrow bands against the whole
// range, prior, candidates.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <random>

#include "perception/stereo/elas/band_matcher.h"
#include "perception/stereo/elas/candidates.h"
#include "perception/stereo/elas/census.h"
#include "perception/stereo/elas/coarse.h"
#include "perception/stereo/elas/lanes.h"
#include "perception/stereo/elas/support.h"
#include "tests/perception/stereo/pictures.h"

namespace arpent::stereo {
namespace {

bool same(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(Census, DescriptorsCountTheNeighboursThatAreAtLeastAsBright) {
  const cv::Mat1b image = texture(20, 30, 1);
  cv::Mat1i census;
  compute_census(image, census);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      int bright = 0;
      for (int dv = -2; dv <= 2; ++dv) {
        for (int du = -2; du <= 2; ++du) {
          const int y = std::clamp(v + dv, 0, image.rows - 1), x = std::clamp(u + du, 0, image.cols - 1);
          bright += (du != 0 || dv != 0) && image(y, x) >= image(v, u) ? 1 : 0;
        }
      }
      EXPECT_EQ(std::popcount(static_cast<unsigned>(census(v, u))), bright);
    }
  }
}

TEST(Census, GainAndOffsetChangeNothing) {
  const cv::Mat1b image = texture(20, 30, 1) / 2;
  cv::Mat1i a, b;
  compute_census(image, a);
  compute_census(image * 1.0 + 40, b);
  EXPECT_TRUE(same(a, b));
}

/// Bands in all positions to each other: equal, apart, overlapping, contiguous.
std::vector<Bands> some_bands() {
  return {{0, 8}, {3, 11}, {3, 40}, {0, 30}, {5, 13}, {25, 33}, {10, 300}, {7, 15}};
}

TEST(Lanes, ALinkFindsEachDisparityInItsPredecessor) {
  for (const Bands& from : some_bands()) {
    for (const Bands& to : some_bands()) {
      const Link link = make_link(from, to);
      for (int lane = 0; lane < kLanes; ++lane) {
        const auto expect = [&](std::uint8_t found, int disparity) {
          int wanted = -1;
          for (int i = 0; i < kLanes; ++i) wanted = from.disparity(i) == disparity ? i : wanted;
          EXPECT_EQ(found >= 0x80 ? -1 : int{found}, wanted);
        };
        const auto i = static_cast<std::size_t>(lane);
        expect(link.same[i], to.disparity(lane));
        expect(link.less[i], to.disparity(lane) - 1);
        expect(link.more[i], to.disparity(lane) + 1);
      }
    }
  }
}

TEST(Lanes, VectorCodeGivesTheBytesOfPlainCode) {
  std::mt19937 random(7);
  const auto bytes = [&](int most) {
    std::array<std::uint8_t, kLanes> b{};
    for (auto& x : b) x = static_cast<std::uint8_t>(random() % static_cast<unsigned>(most + 1));
    return b;
  };
  const auto stored = [](NativeLanes::Vector v) {
    std::array<std::uint8_t, kLanes> b{};
    NativeLanes::store(b.data(), v);
    return b;
  };
  for (int trial = 0; trial < 2000; ++trial) {
    const auto previous = bytes(255), costs = bytes(kCensusBits);
    const auto bands = some_bands();
    const Link link = make_link(bands[random() % bands.size()], bands[random() % bands.size()]);
    const int jump = 11 + static_cast<int>(random() % 60);
    PortableLanes::Vector plain_next;
    const auto plain = PortableLanes::step(previous, link, costs, 8, jump, plain_next);
    NativeLanes::Vector native_next;
    const auto native = NativeLanes::step(NativeLanes::load(previous.data()), link, NativeLanes::load(costs.data()), 8,
                                          jump, native_next);
    EXPECT_EQ(stored(native), plain);
    EXPECT_EQ(stored(native_next), plain_next);
    const LeastLane a = PortableLanes::least(plain), b = NativeLanes::least(native);
    EXPECT_EQ(a.lane, b.lane);
    EXPECT_EQ(a.value, b.value);
    const int limit = 1 + static_cast<int>(random() % 255);
    EXPECT_EQ(PortableLanes::lanes_below(previous, limit),
              NativeLanes::lanes_below(NativeLanes::load(previous.data()), limit));
    std::array<int, kLanes> descriptors{};
    for (int& d : descriptors) d = static_cast<int>(random() & 0xFFFFFFU);
    const int left = static_cast<int>(random() & 0xFFFFFFU);
    EXPECT_EQ(stored(NativeLanes::distances(left, descriptors.data(), descriptors.data() + kBandWidth)),
              PortableLanes::distances(left, descriptors.data(), descriptors.data() + kBandWidth));
  }
}

struct SmallPair {
  cv::Mat1b left = texture(61, 83, 3);
  cv::Mat1b right;
  SmallPair() {
    const cv::Mat1d shift = (cv::Mat1d(2, 3) << 1, 0.06, -9, 0, 1, 0);
    cv::warpAffine(left, right, shift, left.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
  }
};

CandidateGrid everywhere(const cv::Size& size, const Bands& bands) {
  CandidateGrid grid{(size.width + kBlock - 1) / kBlock, (size.height + kBlock - 1) / kBlock, {}};
  grid.bands.assign(static_cast<std::size_t>(grid.cols * grid.rows), bands);
  return grid;
}

TEST(BandMatcher, BandsThatCoverTheRangeGiveWhatTheWholeRangeGives) {
  const SmallPair pair;
  const SmoothnessParams smoothness{.step = 5, .jump = 30};
  const LevelMatch whole = match_whole_range(pair.left, pair.right, kLanes, smoothness);
  LevelMatch bands;
  BandMatcher({.smoothness = smoothness}).match(pair.left, pair.right, everywhere(pair.left.size(), {0, 8}), bands);
  EXPECT_TRUE(same(whole.px128, bands.px128));
  EXPECT_TRUE(same(whole.sharpness, bands.sharpness));
  EXPECT_GT(cv::countNonZero(bands.sharpness), 61 * 83 / 2);
}

/// Bands that wander as on a real level.
CandidateGrid wandering(const cv::Size& size) {
  CandidateGrid grid = everywhere(size, {});
  std::mt19937 random(5);
  for (Bands& b : grid.bands) {
    b.low = static_cast<std::int16_t>(random() % 8);
    b.high = static_cast<std::int16_t>(b.low + kBandWidth + (random() % 3 == 0 ? static_cast<int>(random() % 20) : 0));
  }
  return grid;
}

TEST(BandMatcher, VectorCodeAndThreadsChangeNothing) {
  const SmallPair pair;
  const CandidateGrid grid = wandering(pair.left.size());
  LevelMatch expected;
  BandMatcher({}).match(pair.left, pair.right, grid, expected);
  for (const bool portable : {false, true}) {
    for (const int threads : {1, 2, 3, 7}) {
      LevelMatch match;
      BandMatcher({.threads = threads, .portable = portable}).match(pair.left, pair.right, grid, match);
      EXPECT_TRUE(same(match.px128, expected.px128)) << portable << threads;
      EXPECT_TRUE(same(match.sharpness, expected.sharpness)) << portable << threads;
    }
  }
}

TEST(BandMatcher, AnswersLieWithinTheCandidates) {
  const SmallPair pair;
  const CandidateGrid grid = wandering(pair.left.size());
  LevelMatch match;
  BandMatcher({}).match(pair.left, pair.right, grid, match);
  for (int v = 0; v < match.px128.rows; ++v) {
    for (int u = 0; u < match.px128.cols; ++u) {
      if (match.px128(v, u) == kMissing) continue;
      const Bands& b = grid.row(v / kBlock)[u / kBlock];
      const int nearest = (match.px128(v, u) + 64) / 128;
      EXPECT_TRUE(find_lane(b, nearest) >= 0 || find_lane(b, nearest - 1) >= 0 || find_lane(b, nearest + 1) >= 0);
    }
  }
}

TEST(Support, APlaneIsInterpolatedExactly) {
  const auto plane = [](int u, int v) { return static_cast<std::uint16_t>(2000 + 30 * u - 12 * v); };
  std::vector<SupportPoint> points;
  std::mt19937 random(3);
  for (const auto& [u, v] : {std::pair(0, 0), {59, 0}, {0, 39}, {59, 39}}) points.push_back({u, v, plane(u, v)});
  cv::Mat1b used(40, 60, std::uint8_t{0});
  for (int i = 0; i < 80; ++i) {
    const int u = 1 + static_cast<int>(random() % 58), v = 1 + static_cast<int>(random() % 38);
    if (used(v, u) != 0) continue;
    used(v, u) = 1;
    points.push_back({u, v, plane(u, v)});
  }
  const cv::Mat1w prior = interpolate_prior(points, {60, 40});
  // OpenCV leaves out slivers along the hull.
  for (int v = 0; v < 40; ++v) {
    for (int u = 0; u < 60; ++u) {
      const bool inner = u >= 5 && u < 55 && v >= 5 && v < 35;
      if (!inner && prior(v, u) == kMissing) continue;
      EXPECT_NEAR(prior(v, u), plane(u, v), 1) << u << " " << v;
    }
  }
}

TEST(Support, OutsideOfTheHullAndWithTooFewPointsThereIsNoPrior) {
  const std::vector<SupportPoint> triangle = {{10, 10, 500}, {30, 10, 500}, {10, 30, 500}};
  const cv::Mat1w prior = interpolate_prior(triangle, {60, 40});
  EXPECT_EQ(prior(12, 12), 500);
  EXPECT_EQ(prior(35, 35), kMissing);
  EXPECT_EQ(prior(5, 5), kMissing);
  EXPECT_EQ(cv::countNonZero(interpolate_prior({{1, 1, 5}, {2, 2, 5}}, {60, 40}) != kMissing), 0);
  EXPECT_EQ(cv::countNonZero(interpolate_prior({{1, 1, 5}, {2, 2, 5}, {3, 3, 5}}, {60, 40}) != kMissing), 0)
      << "points on a line span nothing";
}

TEST(Support, TheSharpestMatchOfACellIsTaken) {
  LevelMatch match{cv::Mat1w(10, 10, kMissing), cv::Mat1b(10, 10, std::uint8_t{0})};
  match.px128(2, 3) = 700;
  match.sharpness(2, 3) = 20;
  match.px128(4, 1) = 800;
  match.sharpness(4, 1) = 30;
  match.px128(7, 7) = 900;  // ambiguous: sharpness 0
  const auto points = select_support_points(match);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].u, 1);
  EXPECT_EQ(points[0].v, 4);
  EXPECT_EQ(points[0].px128, 800);
}

TEST(Candidates, CoverTheNeighbourhoodAndThePrior) {
  std::mt19937 random(11);
  cv::Mat1w level(32, 40);
  for (int v = 0; v < level.rows; ++v) {
    // Two surfaces with an edge between them, each a little rough.
    for (int u = 0; u < level.cols; ++u)
      level(v, u) = static_cast<std::uint16_t>((u < 20 ? 5 : 30) * 128 + random() % 128);
  }
  cv::Mat1w prior(level.size(), kMissing);
  prior(20, 4) = 12 * 128;
  const CandidateGrid grid = propose_candidates(level, prior, {80, 64}, 100);
  const auto covered = [&](int row, int col, double px) {
    const Bands& b = grid.row(row)[col];
    const int nearest = static_cast<int>(std::lround(px));
    return find_lane(b, nearest) >= 0;
  };
  for (int row = 0; row < grid.rows; ++row) {
    for (int col = 0; col < grid.cols; ++col) {
      for (int dv = 0; dv < 2; ++dv) {
        for (int du = 0; du < 2; ++du) EXPECT_TRUE(covered(row, col, level(2 * row + dv, 2 * col + du) / 64.0));
      }
      const Bands& b = grid.row(row)[col];
      EXPECT_GE(b.low, 0);
      EXPECT_GE(b.high, b.low + kBandWidth);
      EXPECT_LE(b.high + kBandWidth, 100);
    }
  }
  EXPECT_TRUE(covered(5, 9, 10) && covered(5, 9, 60)) << "both sides of an edge";
  EXPECT_TRUE(covered(10, 2, 24)) << "the prior's proposal";
}

}  // namespace
}  // namespace arpent::stereo
