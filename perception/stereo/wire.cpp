// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/wire.h"

#include <cmath>
#include <utility>

#include "common/image_codec.h"

namespace arpent::stereo {
namespace {

constexpr double kMillimetre = 1e-3;
constexpr double kTenthMillimetre = 1e-4;

Result<cv::Mat> decode_as(const image_t& message, int type, const char* name) {
  auto image = decode_image(message);
  if (!image) return Fault{std::string(name) + ": " + image.fault()};
  if (image->type() != type) return Fault{std::string(name) + ": wrong pixel format"};
  return image;
}

bool is_finite_camera(double fx, double fy, double cx, double cy) {
  return std::isfinite(fx) && std::isfinite(fy) && std::isfinite(cx) && std::isfinite(cy) && fx > 0 && fy > 0;
}

bool is_constant(const cv::Mat1b& image, double level) {
  double least = 0;
  double most = 0;
  cv::minMaxLoc(image, &least, &most);
  return level == 0 ? most <= level + 2 : least >= level - 2;
}

/// Rounded to `unit`, saturated at 65535 if `saturate`, otherwise 0 (missing) when it does not fit.
cv::Mat1w quantise(const cv::Mat1f& values, double unit, bool saturate) {
  cv::Mat1w result;
  values.convertTo(result, CV_16U, 1.0 / unit);
  if (!saturate) result.setTo(0, values > 65535.5 * unit);
  return result;
}

cv::Mat1f scale(const cv::Mat& units, double unit) {
  cv::Mat1f values;
  units.convertTo(values, CV_32F, unit);
  return values;
}

}  // namespace

Result<StereoPair> from_wire(const stereo_images_t& message) {
  auto left = decode_as(message.left, CV_8UC1, "left image");
  if (!left) return Fault{left.fault()};
  auto right = decode_as(message.right, CV_8UC1, "right image");
  if (!right) return Fault{right.fault()};
  if (left->size() != right->size()) return Fault{"left and right images differ in size"};
  if (message.sequence < 0) return Fault{"the sequence is negative"};
  return StereoPair{from_utime(message.utime), message.sequence, *left, *right};
}

stereo_images_t to_wire(const StereoPair& pair, bool compressed) {
  const Compression compression = compressed ? Compression::kZstd : Compression::kNone;
  stereo_images_t message{};
  message.utime = to_utime(pair.stamp);
  message.sequence = pair.sequence;
  message.left = encode_image(pair.left, compression);
  message.right = encode_image(pair.right, compression);
  return message;
}

std::string find_fault(const StereoPair& pair, const PinholeCamera& camera) {
  if (pair.left.cols != camera.width_px || pair.left.rows != camera.height_px) {
    return "its size is not the rig's";
  }
  for (const auto& [image, name] : {std::pair(&pair.left, "left"), std::pair(&pair.right, "right")}) {
    if (is_constant(*image, 0)) return std::string("the ") + name + " image is black";
    if (is_constant(*image, 255)) return std::string("the ") + name + " image is saturated";
  }
  if (cv::norm(pair.left, pair.right, cv::NORM_INF) == 0) return "left and right are the same image";
  return "";
}

std::string FrozenWatch::find_fault(const stereo_images_t& message) {
  const bool left = std::exchange(left_, message.left.crc32c) == message.left.crc32c;
  const bool right = std::exchange(right_, message.right.crc32c) == message.right.crc32c;
  if (left && right) return "both images are those of the last pair: the cameras are frozen";
  if (left || right) return std::string("the ") + (left ? "left" : "right") + " image is that of the last pair: frozen";
  return "";
}

disparity_t to_wire(Time stamp, std::int64_t sequence, DisparityKind kind, const RectifiedStereo& stereo,
                    double vertical_offset_px, const cv::Mat1w& px128) {
  disparity_t message{};
  message.utime = to_utime(stamp);
  message.sequence = sequence;
  message.kind = static_cast<std::int8_t>(kind);
  message.fx_px = stereo.camera.fx_px;
  message.fy_px = stereo.camera.fy_px;
  message.cx_px = stereo.camera.cx_px;
  message.cy_px = stereo.camera.cy_px;
  message.baseline_m = stereo.baseline_m;
  message.vertical_offset_px = vertical_offset_px;
  message.disparity = encode_image(px128);
  return message;
}

Result<StampedDisparity> from_wire(const disparity_t& message) {
  auto disparity = decode_as(message.disparity, CV_16UC1, "disparity");
  if (!disparity) return Fault{disparity.fault()};
  if (message.kind != disparity_t::KIND_TRUSTED && message.kind != disparity_t::KIND_FILLED) {
    return Fault{"unknown kind of disparity"};
  }
  if (!is_finite_camera(message.fx_px, message.fy_px, message.cx_px, message.cy_px) ||
      !std::isfinite(message.baseline_m) || message.baseline_m <= 0) {
    return Fault{"impossible camera"};
  }
  const PinholeCamera camera{disparity->cols, disparity->rows, message.fx_px,
                             message.fy_px,   message.cx_px,   message.cy_px};
  return StampedDisparity{from_utime(message.utime),
                          message.sequence,
                          static_cast<DisparityKind>(message.kind),
                          {camera, message.baseline_m},
                          *disparity};
}

depth_t to_wire(const StampedDepth& depth) {
  depth_t message{};
  message.utime = to_utime(depth.stamp);
  message.sequence = depth.sequence;
  message.fx_px = depth.map.camera.fx_px;
  message.fy_px = depth.map.camera.fy_px;
  message.cx_px = depth.map.camera.cx_px;
  message.cy_px = depth.map.camera.cy_px;
  message.depth = encode_image(quantise(depth.map.depth_m, kMillimetre, false));
  message.sigma = encode_image(quantise(depth.map.sigma_m, kTenthMillimetre, true));
  return message;
}

Result<StampedDepth> from_wire(const depth_t& message) {
  auto depth = decode_as(message.depth, CV_16UC1, "depth");
  if (!depth) return Fault{depth.fault()};
  auto sigma = decode_as(message.sigma, CV_16UC1, "sigma");
  if (!sigma) return Fault{sigma.fault()};
  if (depth->size() != sigma->size()) return Fault{"depth and sigma differ in size"};
  if (!is_finite_camera(message.fx_px, message.fy_px, message.cx_px, message.cy_px)) return Fault{"impossible camera"};
  const PinholeCamera camera{depth->cols, depth->rows, message.fx_px, message.fy_px, message.cx_px, message.cy_px};
  return StampedDepth{from_utime(message.utime),
                      message.sequence,
                      {camera, scale(*depth, kMillimetre), scale(*sigma, kTenthMillimetre)}};
}

}  // namespace arpent::stereo
