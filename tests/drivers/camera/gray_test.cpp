// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/gray.h"

#include <gtest/gtest.h>

#include <vector>

namespace arpent::camera {
namespace {

// Values of the PFNC (GenICam Pixel Format Naming Convention).
constexpr std::uint32_t kMono8 = 0x01080001;
constexpr std::uint32_t kMono12 = 0x01100005;
constexpr std::uint32_t kMono16 = 0x01100007;

TEST(CameraGray, Mono8IsCopiedRowByRowPastItsPadding) {
  const std::vector<std::uint8_t> data = {1, 2, 3, 99, 4, 5, 6, 99};
  const auto image = to_gray8(data, {3, 2}, 4, *genicam_layout(kMono8));
  ASSERT_TRUE(image) << image.fault();
  EXPECT_EQ(image->at<std::uint8_t>(0, 2), 3);
  EXPECT_EQ(image->at<std::uint8_t>(1, 0), 4);
}

TEST(CameraGray, DeeperPixelsKeepTheirEightHighestBits) {
  const std::vector<std::uint8_t> twelve = {0xFF, 0x0F, 0x10, 0x00, 0x0F, 0x00};  // 4095, 16, 15
  const auto image = to_gray8(twelve, {3, 1}, 6, *genicam_layout(kMono12));
  ASSERT_TRUE(image);
  EXPECT_EQ(image->at<std::uint8_t>(0, 0), 255);
  EXPECT_EQ(image->at<std::uint8_t>(0, 1), 1);
  EXPECT_EQ(image->at<std::uint8_t>(0, 2), 0);
  const std::vector<std::uint8_t> sixteen = {0xFF, 0x80};
  EXPECT_EQ((*to_gray8(sixteen, {1, 1}, 2, *genicam_layout(kMono16))).at<std::uint8_t>(0, 0), 0x80);
}

TEST(CameraGray, YuyvGivesItsLuminance) {
  constexpr std::uint32_t yuyv = 'Y' | 'U' << 8 | 'Y' << 16 | 'V' << 24;
  const std::vector<std::uint8_t> data = {10, 128, 20, 128};
  const auto image = to_gray8(data, {2, 1}, 4, *v4l2_layout(yuyv));
  ASSERT_TRUE(image);
  EXPECT_EQ(image->at<std::uint8_t>(0, 0), 10);
  EXPECT_EQ(image->at<std::uint8_t>(0, 1), 20);
}

TEST(CameraGray, MosaicsAndColoursAreRefusedAndNamed) {
  for (const std::uint32_t bayer : {0x01080008U, 0x0108000BU, 0x01100010U, 0x010C002BU, 0x01100031U, 0x010C0053U}) {
    EXPECT_NE(genicam_layout(bayer).fault().find("Bayer"), std::string::npos) << std::hex << bayer;
  }
  EXPECT_FALSE(genicam_layout(0x02180014));  // RGB8
  EXPECT_EQ(genicam_layout(0x02180014).fault().find("Bayer"), std::string::npos);
  constexpr std::uint32_t mjpg = 'M' | 'J' << 8 | 'P' << 16 | 'G' << 24;
  EXPECT_NE(v4l2_layout(mjpg).fault().find("MJPG"), std::string::npos);
  EXPECT_FALSE(to_gray8(cv::Mat(4, 4, CV_8UC3)));
  EXPECT_FALSE(to_gray8(cv::Mat()));
}

TEST(CameraGray, TooFewBytesAreAFaultAndNeverRead) {
  const std::vector<std::uint8_t> data(7);
  EXPECT_FALSE(to_gray8(data, {4, 2}, 4, {8, 1}));
  EXPECT_TRUE(to_gray8(std::vector<std::uint8_t>(7), {3, 2}, 4, {8, 1})) << "the last row needs no padding";
  EXPECT_FALSE(to_gray8(data, {2, 2}, 3, {16, 2})) << "rows shorter than their pixels";
}

}  // namespace
}  // namespace arpent::camera
