// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The pairer against scripted cameras: each frame's moment is written into its image, so that a false pair shows
// itself.
#include "drivers/camera/pairer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace arpent::camera {
namespace {

constexpr std::int64_t kPeriodUs = 200'000;

/// A camera with its own clock and counter that is triggered at moments 0, 1, 2 … each period.
struct Camera {
  std::int64_t first_id = 1;
  std::int64_t id_period = 65535;
  Duration clock_offset{0};  ///< its clock less ours
  double drift = 0;
  double mean_delay_us = 3000;
  std::uint64_t seed = 1;
  std::int64_t session = 0;

  Frame frame(std::int64_t moment, Duration late = Duration(0)) {
    const Time truth(Duration(1'000'000'000 + moment * kPeriodUs));
    Frame f;
    f.image = cv::Mat1b(1, 2);
    f.image(0, 0) = static_cast<std::uint8_t>(moment & 0xFF);
    f.image(0, 1) = static_cast<std::uint8_t>(moment >> 8);
    f.frame_id = id_period > 0 ? (first_id - 1 + moment) % id_period + 1 : first_id + moment;
    f.id_period = id_period;
    f.session = session;
    f.exposure_us = 2000;
    f.device_time = truth + late + clock_offset + Duration(std::llround(drift * double(moment * kPeriodUs)));
    std::mt19937_64 random(seed * 1000003 + static_cast<std::uint64_t>(moment));
    f.arrival = truth + Duration(2000) +
                Duration(std::llround(std::exponential_distribution<double>(1 / mean_delay_us)(random)));
    return f;
  }
};

std::int64_t moment_of(const Frame& frame) {
  return frame.image(0, 0) | frame.image(0, 1) << 8;
}

class CameraPairer : public testing::TestWithParam<const char*> {
 protected:
  CameraPairer() {
    params_.by = GetParam();
    left_ = {65500, 65535, Duration(777'000'000), 40e-6, 3000, 1, 0};
    right_ = {3000, 65535, Duration(-555'123'456), -30e-6, 8000, 2, 0};
  }
  void add(Side side, std::int64_t moment, Duration late = Duration(0)) {
    pairer_->add(side, (side == Side::kLeft ? left_ : right_).frame(moment, late));
    for (FramePair& pair : pairer_->take()) pairs_.push_back(std::move(pair));
  }
  void both(std::int64_t from, std::int64_t to) {
    for (std::int64_t m = from; m < to; ++m) {
      add(Side::kLeft, m);
      add(Side::kRight, m);
    }
  }
  void expect_true_pairs() const {
    for (const FramePair& pair : pairs_) {
      ASSERT_EQ(moment_of(pair.left), moment_of(pair.right));
      const Time middle(Duration(1'000'000'000 + moment_of(pair.left) * kPeriodUs + 1000));
      // The stamp leans on the least of the left camera's delays.
      ASSERT_LT(std::abs(double((pair.stamp - middle).count())), 5000) << "moment " << moment_of(pair.left);
    }
    for (std::size_t i = 1; i < pairs_.size(); ++i) {
      ASSERT_EQ(pairs_[i].sequence - pairs_[i - 1].sequence, moment_of(pairs_[i].left) - moment_of(pairs_[i - 1].left));
      ASSERT_GT(pairs_[i].stamp, pairs_[i - 1].stamp);
    }
  }
  void start() { pairer_.emplace(params_); }

  PairerParams params_;
  Camera left_;
  Camera right_;
  std::optional<Pairer> pairer_;
  std::vector<FramePair> pairs_;
};

INSTANTIATE_TEST_SUITE_P(By, CameraPairer, testing::Values("frame_id", "device_time"));

TEST_P(CameraPairer, PairsCamerasWithOtherClocksOtherCountersDriftAndAWrap) {
  start();
  both(0, 500);
  expect_true_pairs();
  EXPECT_EQ(pairer_->counts().pairs + pairer_->counts().warm_up / 2, 500);
  EXPECT_LE(pairer_->counts().warm_up / 2,
            params_.warm_up_frames);  // all but the last of the warm-up, and one late frame
  EXPECT_EQ(pairer_->counts().out_of_tolerance, 0);
  EXPECT_EQ(pairer_->counts().unpaired[0] + pairer_->counts().unpaired[1], 0);
  EXPECT_EQ(pairer_->counts().locks, 1);
}

/// A computer that is busy at the start gets one camera's frames late and works them off.
TEST_P(CameraPairer, FramesThatComeLateAtTheStartDoNotRelateTheCamerasAPeriodOff) {
  start();
  const auto add_late = [&](Side side, std::int64_t moment, std::int64_t behind_us) {
    Frame frame = (side == Side::kLeft ? left_ : right_).frame(moment);
    frame.arrival += Duration(behind_us);
    pairer_->add(side, std::move(frame));
    for (FramePair& pair : pairer_->take()) pairs_.push_back(std::move(pair));
  };
  for (std::int64_t m = 0; m < 6; ++m) {
    add_late(Side::kLeft, m, 0);
    add_late(Side::kRight, m, kPeriodUs * (20 - 3 * m) / 10);  // two periods at first, half a period at last
  }
  EXPECT_TRUE(pairs_.empty()) << "nothing is known of the right camera's clock yet";
  both(6, 50);
  expect_true_pairs();
  EXPECT_EQ(pairer_->counts().locks, 1);
  EXPECT_GE(pairer_->counts().pairs, 44 - params_.warm_up_frames);
}

TEST_P(CameraPairer, LosesOnlyTheHalvesWhosePartnerIsLostAndCountsThem) {
  start();
  std::mt19937 random(5);
  std::bernoulli_distribution lost(0.1);
  both(0, 10);
  std::array<std::int64_t, 2> alone{};
  for (std::int64_t m = 10; m < 400; ++m) {
    const bool no_left = lost(random);
    const bool no_right = lost(random);
    if (!no_left) add(Side::kLeft, m);
    if (!no_right) add(Side::kRight, m);
    if (no_right && !no_left) ++alone[0];
    if (no_left && !no_right) ++alone[1];
  }
  both(400, 402);
  expect_true_pairs();
  EXPECT_EQ(pairer_->counts().unpaired[0], alone[0]);
  EXPECT_EQ(pairer_->counts().unpaired[1], alone[1]);
  EXPECT_EQ(pairer_->counts().out_of_tolerance, 0);
}

TEST_P(CameraPairer, OrderOfArrivalDoesNotMatter) {
  start();
  both(0, 10);
  for (std::int64_t m = 10; m < 40; m += 3) {  // the left camera's frames come three at a time, before the right ones
    for (std::int64_t i = m; i < m + 3; ++i) add(Side::kLeft, i);
    for (std::int64_t i = m; i < m + 3; ++i) add(Side::kRight, i);
  }
  expect_true_pairs();
  EXPECT_EQ(pairer_->counts().unpaired[0] + pairer_->counts().unpaired[1], 0);
  EXPECT_EQ(moment_of(pairs_.back().left), 39);
}

TEST_P(CameraPairer, AHalfThatComesTooLateFindsItsPartnerGone) {
  start();
  both(0, 10);
  const Frame late = right_.frame(10);
  for (std::int64_t m = 10; m < 30; ++m) add(Side::kLeft, m);  // eight of them may wait
  EXPECT_EQ(pairer_->counts().unpaired[0], 12);
  pairer_->add(Side::kRight, late);
  both(30, 33);
  expect_true_pairs();
  EXPECT_EQ(pairer_->counts().unpaired[1], 1);
  EXPECT_EQ(moment_of(pairs_.back().left), 32);
}

TEST_P(CameraPairer, APairBeyondTheToleranceIsDroppedAndCounted) {
  start();
  both(0, 20);
  const auto before = pairer_->counts().pairs;
  add(Side::kLeft, 20);
  add(Side::kRight, 20, Duration(30'000));  // fault F7: 30 ms out of step
  EXPECT_EQ(pairer_->counts().out_of_tolerance, 1);
  EXPECT_EQ(pairer_->counts().pairs, before);
  both(21, 30);
  expect_true_pairs();
  EXPECT_EQ(moment_of(pairs_.back().left), 29);
}

TEST_P(CameraPairer, ASkewWithinTheToleranceIsKeptAndSaid) {
  start();
  both(0, 20);
  add(Side::kLeft, 20);
  add(Side::kRight, 20, Duration(1500));
  ASSERT_EQ(moment_of(pairs_.back().left), 20);
  EXPECT_NEAR(double(pairs_.back().skew.count()), 1500, 200);
}

TEST_P(CameraPairer, ACameraThatStartsAnewIsRelatedAnew) {
  start();
  both(0, 20);
  right_.first_id = 40000;
  right_.clock_offset = Duration(99'000'000);
  right_.session = 1;
  both(20, 60);
  for (const FramePair& pair : pairs_) ASSERT_EQ(moment_of(pair.left), moment_of(pair.right));
  EXPECT_EQ(pairer_->counts().locks, 2);
  EXPECT_EQ(moment_of(pairs_.back().left), 59);
  EXPECT_GE(pairer_->counts().pairs, 50 - params_.warm_up_frames - 1);
}

TEST_P(CameraPairer, AFrozenCameraRepeatsItsFrameAndGivesNoPairs) {
  start();
  both(0, 20);
  const auto before = pairer_->counts().pairs;
  for (std::int64_t m = 20; m < 25; ++m) {
    add(Side::kLeft, m);
    add(Side::kRight, 19);
  }
  EXPECT_EQ(pairer_->counts().repeated[1], 5);
  EXPECT_EQ(pairer_->counts().pairs, before);
  both(25, 30);
  expect_true_pairs();
}

TEST_P(CameraPairer, NothingPilesUpBehindADeadCamera) {
  start();
  for (std::int64_t m = 0; m < 1000; ++m) add(Side::kLeft, m);
  EXPECT_TRUE(pairs_.empty());
  EXPECT_EQ(pairer_->counts().unpaired[0], 1000 - params_.queue);
}

TEST_P(CameraPairer, CamerasWithOneClockNeedNoWarmUp) {
  params_.clocks = "bus";
  left_.clock_offset = right_.clock_offset = Duration(0);
  left_.drift = right_.drift = 0;
  start();
  both(0, 10);
  ASSERT_EQ(pairs_.size(), 10U);
  EXPECT_EQ(pairs_[0].stamp, Time(Duration(1'000'001'000)));
  EXPECT_EQ(pairs_[0].sequence, 0);
  expect_true_pairs();
}

TEST(CameraPairerById, ACounterThatSlipsByOneIsNoticedByTheTimesAndMended) {
  PairerParams params;
  Pairer pairer(params);
  Camera left;
  Camera right;
  right.seed = 2;
  std::vector<FramePair> pairs;
  for (std::int64_t m = 0; m < 60; ++m) {
    if (m == 30) ++right.first_id;  // the right camera counted a trigger that the left one did not see
    pairer.add(Side::kLeft, left.frame(m));
    pairer.add(Side::kRight, right.frame(m));
    for (FramePair& pair : pairer.take()) pairs.push_back(std::move(pair));
  }
  for (const FramePair& pair : pairs) ASSERT_EQ(moment_of(pair.left), moment_of(pair.right));
  EXPECT_EQ(moment_of(pairs.back().left), 59);
  EXPECT_EQ(pairer.counts().locks, 2);
  EXPECT_GE(pairer.counts().out_of_tolerance, 1);
}

}  // namespace
}  // namespace arpent::camera
