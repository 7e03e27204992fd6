// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/image_codec.h"

#include <gtest/gtest.h>

#include "common/crc32c.h"

namespace arpent {
namespace {

cv::Mat noise(int rows, int cols, int type) {
  cv::Mat image(rows, cols, type);
  cv::RNG rng(7);
  rng.fill(image, cv::RNG::UNIFORM, 0, type == CV_8UC1 ? 256 : 65536);
  return image;
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

void seal(image_t& message) {
  message.size_bytes = static_cast<std::int32_t>(message.data.size());
  message.crc32c = static_cast<std::int32_t>(crc32c_of(std::span<const std::uint8_t>(message.data)));
}

TEST(ImageCodec, RawPngAndZstdAreLossless) {
  for (const int type : {CV_8UC1, CV_16UC1}) {
    for (const Compression compression : {Compression::kNone, Compression::kPng, Compression::kZstd}) {
      const cv::Mat image = noise(37, 53, type);
      const auto decoded = decode_image(encode_image(image, compression));
      ASSERT_TRUE(decoded) << decoded.fault();
      EXPECT_TRUE(equal(*decoded, image));
    }
  }
}

TEST(ImageCodec, APartOfALargerImageIsEncodedByItsOwnRows) {
  const cv::Mat image = noise(40, 60, CV_8UC1);
  const cv::Mat part = image(cv::Rect(5, 7, 20, 10));
  EXPECT_TRUE(equal(*decode_image(encode_image(part)), part.clone()));
}

TEST(ImageCodec, PaddedRowsAreUnderstood) {
  image_t message = encode_image(cv::Mat1b(2, 3, std::uint8_t{5}));
  message.row_stride_bytes = 4;
  message.data = {1, 2, 3, 99, 4, 5, 6, 99};
  seal(message);
  const auto decoded = decode_image(message);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->at<std::uint8_t>(1, 2), 6);
}

TEST(ImageCodec, EachFaultIsRefused) {
  const image_t good = encode_image(noise(8, 8, CV_8UC1));
  const auto refused = [&](auto damage) {
    image_t bad = good;
    damage(bad);
    return !decode_image(bad);
  };
  EXPECT_FALSE(refused([](image_t&) {}));
  EXPECT_TRUE(refused([](image_t& m) { m.data[5] ^= 1; })) << "CRC";
  EXPECT_TRUE(refused([](image_t& m) { m.width_px = -8; }));
  EXPECT_TRUE(refused([](image_t& m) { m.height_px = 100000; }));
  EXPECT_TRUE(refused([](image_t& m) { m.width_px = 9; }));
  EXPECT_TRUE(refused([](image_t& m) { m.row_stride_bytes = 7; }));
  EXPECT_TRUE(refused([](image_t& m) { m.row_stride_bytes = -8; }));
  EXPECT_TRUE(refused([](image_t& m) { m.pixel_format = 17; }));
  EXPECT_TRUE(refused([](image_t& m) { m.compression = 17; }));
  EXPECT_TRUE(refused([](image_t& m) { m.size_bytes = 63; }));
  EXPECT_TRUE(refused([](image_t& m) { m.compression = image_t::COMPRESSION_PNG; })) << "raw data is no PNG file";
}

TEST(ImageCodec, APngThatLiesAboutItsSizeIsRefusedBeforeItIsDecoded) {
  image_t message = encode_image(noise(8, 8, CV_8UC1), Compression::kPng);
  message.data[18] = 0x3F;  // width in the header chunk: 16136
  seal(message);
  EXPECT_FALSE(decode_image(message));
  message.width_px = 0x3F08;
  EXPECT_FALSE(decode_image(message)) << "too little data for the stated size";
}

TEST(ImageCodec, ZstdDataThatLiesOrIsCutIsRefused) {
  const image_t good = encode_image(noise(8, 8, CV_16UC1), Compression::kZstd);
  ASSERT_TRUE(decode_image(good));
  image_t bad = good;
  bad.width_px = 16000;
  EXPECT_FALSE(decode_image(bad)) << "another size than the frame's";
  bad = good;
  bad.pixel_format = image_t::PIXEL_GRAY8;
  EXPECT_FALSE(decode_image(bad));
  for (std::size_t size = 0; size < good.data.size(); ++size) {
    bad = good;
    bad.data.resize(size);
    seal(bad);
    EXPECT_FALSE(decode_image(bad)) << size;
  }
}

TEST(ImageCodec, ZstdShrinksSmoothImagesAboutAsFarAsPng) {
  cv::Mat1b image(200, 300);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) image(v, u) = static_cast<std::uint8_t>(u / 2 + v / 3 + (u * 7 + v * 13) % 3);
  }
  const auto size = [&](Compression compression) { return encode_image(image, compression).data.size(); };
  EXPECT_LT(size(Compression::kZstd), size(Compression::kNone) / 3);
}

}  // namespace
}  // namespace arpent
