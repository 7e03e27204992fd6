// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/depth.h"

#include "common/error.h"

namespace arpent::stereo {

DepthMap depth_from_disparity(const cv::Mat1w& px128, const cv::Mat1f& sigma_px, const RectifiedStereo& stereo,
                              double min_range_m, double max_range_m) {
  ARPENT_ASSERT(px128.size() == sigma_px.size());
  const auto Bf = static_cast<float>(stereo.baseline_m * stereo.camera.fx_px);
  const auto nearest_m = static_cast<float>(min_range_m);
  const auto farthest_m = static_cast<float>(max_range_m);
  DepthMap depth{stereo.camera, cv::Mat1f(px128.size(), 0.0F), cv::Mat1f(px128.size(), 0.0F)};
  for (int v = 0; v < px128.rows; ++v) {
    for (int u = 0; u < px128.cols; ++u) {
      const std::uint16_t units = px128(v, u);
      if (units == kMissing || units == 0) continue;
      const float z = Bf * kUnitsPerPixel / static_cast<float>(units);  // eq. A.12
      if (z < nearest_m || z > farthest_m) continue;
      depth.depth_m(v, u) = z;
      depth.sigma_m(v, u) = z * z * sigma_px(v, u) / Bf;
    }
  }
  return depth;
}

}  // namespace arpent::stereo
