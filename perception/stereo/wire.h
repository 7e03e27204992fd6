// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages <-> types of stereo: stereo_images_t, disparity_t, depth_t. Everything that is received is checked here
// (CRC, size, format, finiteness, ranges); a fault is a sentence, never a default value.
#pragma once

#include <arpent/depth_t.hpp>
#include <arpent/disparity_t.hpp>
#include <arpent/stereo_images_t.hpp>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/camera.h"
#include "common/result.h"
#include "common/time.h"
#include "perception/stereo/depth_map.h"

namespace arpent::stereo {

/// Both images of one moment: 8-bit, same size.
struct StereoPair {
  Time stamp;
  std::int64_t sequence = 0;
  cv::Mat1b left;
  cv::Mat1b right;
};

[[nodiscard]] Result<StereoPair> from_wire(const stereo_images_t& message);
/// `compressed`: both images shrunk without loss (for logs); otherwise raw.
[[nodiscard]] stereo_images_t to_wire(const StereoPair& pair, bool compressed);

/// Why a pair cannot be used: not of the camera's size, all black, saturated, or twice the same image. Empty if it can.
[[nodiscard]] std::string find_fault(const StereoPair& pair, const PinholeCamera& camera);

/// Finds cameras that repeat their last image under a new time: noise makes no two images alike.
class FrozenWatch {
 public:
  /// Why this pair cannot be used after the one that was asked about before; empty if it can.
  [[nodiscard]] std::string find_fault(const stereo_images_t& message);

 private:
  /// Checksums of the last pair.
  std::optional<std::int32_t> left_, right_;
};

enum class DisparityKind : std::int8_t { kTrusted = 0, kFilled = 1 };
[[nodiscard]] disparity_t to_wire(Time stamp, std::int64_t sequence, DisparityKind kind, const RectifiedStereo& stereo,
                                  double vertical_offset_px, const cv::Mat1w& px128);

struct StampedDisparity {
  Time stamp;
  std::int64_t sequence = 0;
  DisparityKind kind = DisparityKind::kTrusted;
  RectifiedStereo stereo;
  cv::Mat1w px128;
};
[[nodiscard]] Result<StampedDisparity> from_wire(const disparity_t& message);

struct StampedDepth {
  Time stamp;
  std::int64_t sequence = 0;
  DepthMap map;
};
/// Depth is rounded to 1 mm (what is beyond 65.535 m becomes missing), its deviation to 0.1 mm.
[[nodiscard]] depth_t to_wire(const StampedDepth& depth);
[[nodiscard]] Result<StampedDepth> from_wire(const depth_t& message);

}  // namespace arpent::stereo
