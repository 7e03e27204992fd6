// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/folder_source.h"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "common/error.h"

namespace arpent::camera {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class CameraFolder : public testing::Test {
 protected:
  CameraFolder() { fs::create_directories(folder_); }
  ~CameraFolder() override { fs::remove_all(folder_); }

  void write(const std::string& name, const cv::Mat& image) {
    fs::create_directories((folder_ / name).parent_path());
    cv::imwrite((folder_ / name).string(), image);
  }
  void write(const std::string& name, int level) { write(name, cv::Mat1b(4, 6, static_cast<std::uint8_t>(level))); }
  auto open() {
    return open_folder(params(), [this] { return now_; });
  }
  FolderParams params() const {
    FolderParams params = params_;
    params.path = folder_;
    return params;
  }

  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("folder_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  FolderParams params_;
  Time now_{100s};
};

TEST_F(CameraFolder, PlaysAtItsRateAndNeverEarly) {
  for (int i = 0; i < 3; ++i) {
    write("left_" + std::to_string(i) + ".png", 10 + i);
    write("right_" + std::to_string(i) + ".png", 20 + i);
  }
  auto [left, right] = open();
  EXPECT_EQ(left->next(0s)->image(0, 0), 10);
  EXPECT_FALSE(left->next(0s));
  now_ += 199ms;
  EXPECT_FALSE(left->next(0s));
  now_ += 1ms;
  const auto second = left->next(0s);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->image(0, 0), 11);
  EXPECT_EQ(second->device_time, Time(100s) + 200ms);
  EXPECT_EQ(second->frame_id, 1);
  now_ += 10s;
  EXPECT_TRUE(left->next(0s));
  EXPECT_FALSE(left->next(0s)) << "it ends";
  EXPECT_EQ(right->next(0s)->image(0, 0), 20);
}

TEST_F(CameraFolder, TimesComeFromAFileOrFromNamesInNanoseconds) {
  for (const char* name : {"a", "b"}) {
    write(std::string("left/") + name + ".png", 1);
    write(std::string("right/") + name + ".png", 2);
  }
  std::ofstream(folder_ / "timestamps.txt") << "# seconds\n1000.5\n1000.75\n";
  EXPECT_EQ(list_folder(params()).time, (std::vector<Duration>{0s, 250ms}));
  fs::remove_all(folder_);
  for (const char* ns : {"1403636579763555584", "1403636579813555456"}) {
    write(std::string("cam0/data/") + ns + ".png", 1);
    write(std::string("cam1/data/") + ns + ".png", 2);
  }
  EXPECT_EQ(list_folder(params()).time, (std::vector<Duration>{0s, 49999us}));
}

TEST_F(CameraFolder, RepeatsWithoutAJumpInRhythm) {
  write("left0.png", 1), write("right0.png", 1), write("left1.png", 2), write("right1.png", 2);
  params_.repeat = true;
  auto [left, right] = open();
  now_ += 600ms;
  std::vector<int> levels;
  std::vector<Time> times;
  while (auto frame = left->next(0s)) {
    levels.push_back(frame->image(0, 0));
    times.push_back(frame->device_time);
  }
  EXPECT_EQ(levels, (std::vector<int>{1, 2, 1, 2}));
  EXPECT_EQ(times.back(), Time(100s) + 600ms);
}

TEST_F(CameraFolder, SixteenBitsAreScaledAndColourIsPassedOverAndCounted) {
  write("left0.png", cv::Mat1w(4, 6, std::uint16_t{0x8123}));
  write("left1.png", cv::Mat(4, 6, CV_8UC3, cv::Scalar(1, 2, 3)));
  write("right0.png", 1), write("right1.png", 1);
  auto [left, right] = open();
  now_ += 10s;
  EXPECT_EQ(left->next(0s)->image(0, 0), 0x81);
  EXPECT_FALSE(left->next(0s));
  EXPECT_EQ(left->incomplete(), 1);
}

TEST_F(CameraFolder, WhatCannotBePlayedIsOneClearError) {
  EXPECT_THROW((void)list_folder(params()), InputError) << "no images";
  write("left0.png", 1), write("right0.png", 1), write("left1.png", 1);
  EXPECT_THROW((void)list_folder(params()), InputError) << "a right image is missing";
  write("right1.png", 1);
  std::ofstream(folder_ / "timestamps.txt") << "1\n";
  EXPECT_THROW((void)list_folder(params()), InputError) << "too few times";
  std::ofstream(folder_ / "timestamps.txt") << "2\n1\n";
  EXPECT_THROW((void)list_folder(params()), InputError) << "times go back";
  std::ofstream(folder_ / "timestamps.txt") << "1\nnow\n";
  EXPECT_THROW((void)list_folder(params()), InputError) << "no number";
  FolderParams nowhere;
  nowhere.path = folder_ / "nowhere";
  EXPECT_THROW((void)list_folder(nowhere), InputError);
}

}  // namespace
}  // namespace arpent::camera
