// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/gray.h"

#include <fmt/format.h>

namespace arpent::camera {
namespace {

struct Known {
  std::uint32_t format;
  GrayLayout layout;
};

constexpr Known kGenicam[] = {
    {0x01080001, {8, 1}}, {0x01100003, {10, 2}}, {0x01100005, {12, 2}}, {0x01100025, {14, 2}}, {0x01100007, {16, 2}},
};

constexpr std::uint32_t fourcc(const char (&text)[5]) {
  std::uint32_t code = 0;
  for (int i = 3; i >= 0; --i) code = code << 8 | static_cast<std::uint8_t>(text[i]);
  return code;
}

constexpr Known kV4l2[] = {
    {fourcc("GREY"), {8, 1}},  {fourcc("Y10 "), {10, 2}}, {fourcc("Y12 "), {12, 2}},
    {fourcc("Y16 "), {16, 2}}, {fourcc("YUYV"), {8, 2}},
};

/// PFNC 2.4: the Bayer formats are 0x08 to 0x13, 0x26 to 0x31 and 0x52 to 0x59 of the one-component formats.
bool is_bayer(std::uint32_t format) {
  const std::uint32_t id = format & 0xFFFF;
  const bool mono = format >> 24 == 0x01;
  return mono && ((id >= 0x08 && id <= 0x13) || (id >= 0x26 && id <= 0x31) || (id >= 0x52 && id <= 0x59));
}

std::uint8_t top_bits(const std::uint8_t* pixel, GrayLayout layout) {
  if (layout.bits == 8) return *pixel;
  const int value = pixel[0] | pixel[1] << 8;
  return static_cast<std::uint8_t>(value >> (layout.bits - 8));
}

}  // namespace

Result<GrayLayout> genicam_layout(std::uint32_t pixel_format) {
  for (const Known& known : kGenicam) {
    if (known.format == pixel_format) return known.layout;
  }
  if (is_bayer(pixel_format)) {
    return Fault{fmt::format(
        "pixel format {:#010x} is a Bayer mosaic: use a monochrome camera, or one that offers Mono8", pixel_format)};
  }
  return Fault{fmt::format("pixel format {:#010x} is none of Mono8, Mono10, Mono12, Mono14, Mono16", pixel_format)};
}

std::string fourcc_text(std::uint32_t code) {
  std::string text;
  for (int i = 0; i < 4; ++i) text += static_cast<char>(code >> (8 * i) & 0x7F);
  return text;
}

Result<GrayLayout> v4l2_layout(std::uint32_t code) {
  for (const Known& known : kV4l2) {
    if (known.format == code) return known.layout;
  }
  return Fault{fmt::format("pixel format '{}' is none of GREY, Y10, Y12, Y16, YUYV", fourcc_text(code))};
}

Result<cv::Mat> to_gray8(std::span<const std::uint8_t> data, cv::Size size_px, std::size_t row_bytes,
                         GrayLayout layout) {
  const std::size_t needed_row = static_cast<std::size_t>(size_px.width) * static_cast<std::size_t>(layout.bytes);
  const auto rows = static_cast<std::size_t>(size_px.height);
  if (size_px.empty() || row_bytes < needed_row || data.size() < row_bytes * (rows - 1) + needed_row) {
    return Fault{fmt::format("{} bytes are too few for {} x {} pixels", data.size(), size_px.width, size_px.height)};
  }
  cv::Mat image(size_px, CV_8UC1);
  for (std::size_t y = 0; y < rows; ++y) {
    const std::uint8_t* from = data.data() + y * row_bytes;
    std::uint8_t* to = image.ptr(static_cast<int>(y));
    for (int x = 0; x < size_px.width; ++x, from += layout.bytes) to[x] = top_bits(from, layout);
  }
  return image;
}

Result<cv::Mat> to_gray8(const cv::Mat& image) {
  if (image.empty()) return Fault{"is no image that can be read"};
  if (image.type() != CV_8UC1 && image.type() != CV_16UC1) return Fault{"has colour: a grey image is needed"};
  const GrayLayout layout = image.type() == CV_8UC1 ? GrayLayout{8, 1} : GrayLayout{16, 2};
  const std::size_t size = image.step * static_cast<std::size_t>(image.rows);
  return to_gray8({image.data, size}, image.size(), image.step, layout);
}

}  // namespace arpent::camera
