// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/image_codec.h"

#include <zstd.h>

#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "common/crc32c.h"
#include "common/error.h"

namespace arpent {
namespace {

constexpr int kMaxSidePx = 16384;
constexpr std::int64_t kMaxPixels = 64 << 20;
/// Level 1 of 9: a grey pair shrinks nearly as far as with 9, in a tenth of the time.
const std::vector<int> kPngOptions{cv::IMWRITE_PNG_COMPRESSION, 1};

/// The fastest level: what is left of a photograph after prediction is mostly noise.
constexpr int kZstdLevel = 1;

std::int32_t checksum(const std::vector<std::uint8_t>& data) {
  return static_cast<std::int32_t>(crc32c_of(std::span<const std::uint8_t>(data)));
}

/// Width and height that a PNG file states in its header chunk (bytes 16 to 23, big-endian); zero if it is no PNG file.
std::pair<std::uint32_t, std::uint32_t> png_size(const std::vector<std::uint8_t>& data) {
  static constexpr std::uint8_t kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  if (data.size() < 33 || std::memcmp(data.data(), kSignature, 8) != 0) return {0, 0};
  const auto word = [&](std::size_t at) {
    return std::uint32_t{data[at]} << 24 | std::uint32_t{data[at + 1]} << 16 | std::uint32_t{data[at + 2]} << 8 |
           std::uint32_t{data[at + 3]};
  };
  return {word(16), word(20)};
}

std::string find_fault(const image_t& message) {
  if (message.width_px <= 0 || message.height_px <= 0 || message.width_px > kMaxSidePx ||
      message.height_px > kMaxSidePx || std::int64_t{message.width_px} * message.height_px > kMaxPixels) {
    return "impossible image size";
  }
  if (message.pixel_format != image_t::PIXEL_GRAY8 && message.pixel_format != image_t::PIXEL_GRAY16) {
    return "unknown pixel format";
  }
  if (message.size_bytes != static_cast<std::int32_t>(message.data.size())) return "size_bytes does not fit the data";
  if (checksum(message.data) != message.crc32c) return "CRC-32C does not match: damaged image data";
  return "";
}

Result<cv::Mat> decode_raw(const image_t& message, int type) {
  const std::size_t row_bytes =
      static_cast<std::size_t>(message.width_px) * (message.pixel_format == image_t::PIXEL_GRAY8 ? 1 : 2);
  const auto stride = static_cast<std::size_t>(message.row_stride_bytes);
  if (message.row_stride_bytes < 0 || stride < row_bytes ||
      message.data.size() != stride * static_cast<std::size_t>(message.height_px)) {
    return Fault{"row stride, height and data size do not fit"};
  }
  cv::Mat image(message.height_px, message.width_px, type);
  for (int v = 0; v < image.rows; ++v) {
    std::memcpy(image.ptr(v), message.data.data() + static_cast<std::size_t>(v) * stride, row_bytes);
  }
  return image;
}

Result<cv::Mat> decode_png(const image_t& message, int type) {
  const auto [width, height] = png_size(message.data);
  if (static_cast<std::int64_t>(width) != message.width_px || static_cast<std::int64_t>(height) != message.height_px) {
    return Fault{"the PNG data is not of the stated size"};
  }
  cv::Mat image = cv::imdecode(message.data, cv::IMREAD_UNCHANGED);
  if (image.empty() || image.type() != type) return Fault{"the PNG data cannot be decoded to the stated format"};
  return image;
}

/// Each row but the first becomes its difference from the row above, modulo the pixel's range.
template <class Pixel>
cv::Mat predict_rows(const cv::Mat& image) {
  cv::Mat residual(image.size(), image.type());
  for (int v = 0; v < image.rows; ++v) {
    const auto* row = image.ptr<Pixel>(v);
    const auto* above = v > 0 ? image.ptr<Pixel>(v - 1) : nullptr;
    auto* to = residual.ptr<Pixel>(v);
    for (int u = 0; u < image.cols; ++u) to[u] = static_cast<Pixel>(row[u] - (above ? above[u] : 0));
  }
  return residual;
}

/// Takes predict_rows back, in place.
template <class Pixel>
void restore_rows(cv::Mat& residual) {
  for (int v = 1; v < residual.rows; ++v) {
    const auto* above = residual.ptr<Pixel>(v - 1);
    auto* row = residual.ptr<Pixel>(v);
    for (int u = 0; u < residual.cols; ++u) row[u] = static_cast<Pixel>(row[u] + above[u]);
  }
}

std::vector<std::uint8_t> encode_zstd(const cv::Mat& image) {
  const cv::Mat residual =
      image.depth() == CV_8U ? predict_rows<std::uint8_t>(image) : predict_rows<std::uint16_t>(image);
  const std::size_t bytes = residual.total() * residual.elemSize();
  std::vector<std::uint8_t> data(ZSTD_compressBound(bytes));
  const std::size_t size = ZSTD_compress(data.data(), data.size(), residual.data, bytes, kZstdLevel);
  ARPENT_ASSERT(ZSTD_isError(size) == 0);
  data.resize(size);
  return data;
}

Result<cv::Mat> decode_zstd(const image_t& message, int type) {
  cv::Mat image(message.height_px, message.width_px, type);
  const std::size_t bytes = image.total() * image.elemSize();
  if (ZSTD_getFrameContentSize(message.data.data(), message.data.size()) != bytes) {
    return Fault{"the zstd data is not of the stated size"};
  }
  if (ZSTD_decompress(image.data, bytes, message.data.data(), message.data.size()) != bytes) {
    return Fault{"the zstd data cannot be decoded"};
  }
  type == CV_8UC1 ? restore_rows<std::uint8_t>(image) : restore_rows<std::uint16_t>(image);
  return image;
}

}  // namespace

image_t encode_image(const cv::Mat& image, Compression compression) {
  ARPENT_ASSERT(image.type() == CV_8UC1 || image.type() == CV_16UC1);
  image_t message{};
  message.width_px = image.cols;
  message.height_px = image.rows;
  message.pixel_format = image.type() == CV_8UC1 ? image_t::PIXEL_GRAY8 : image_t::PIXEL_GRAY16;
  if (compression == Compression::kPng) {
    message.compression = image_t::COMPRESSION_PNG;
    cv::imencode(".png", image, message.data, kPngOptions);
  } else if (compression == Compression::kZstd) {
    message.compression = image_t::COMPRESSION_ZSTD;
    message.data = encode_zstd(image);
  } else {
    const std::size_t row_bytes = static_cast<std::size_t>(image.cols) * image.elemSize();
    message.compression = image_t::COMPRESSION_NONE;
    message.row_stride_bytes = static_cast<std::int32_t>(row_bytes);
    message.data.resize(row_bytes * static_cast<std::size_t>(image.rows));
    for (int v = 0; v < image.rows; ++v) {
      std::memcpy(message.data.data() + static_cast<std::size_t>(v) * row_bytes, image.ptr(v), row_bytes);
    }
  }
  message.size_bytes = static_cast<std::int32_t>(message.data.size());
  message.crc32c = checksum(message.data);
  return message;
}

Result<cv::Mat> decode_image(const image_t& message) {
  if (std::string fault = find_fault(message); !fault.empty()) return Fault{std::move(fault)};
  const int type = message.pixel_format == image_t::PIXEL_GRAY8 ? CV_8UC1 : CV_16UC1;
  if (message.compression == image_t::COMPRESSION_NONE) return decode_raw(message, type);
  if (message.compression == image_t::COMPRESSION_PNG) return decode_png(message, type);
  if (message.compression == image_t::COMPRESSION_ZSTD) return decode_zstd(message, type);
  return Fault{"unknown compression"};
}

}  // namespace arpent
