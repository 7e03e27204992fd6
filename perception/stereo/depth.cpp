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
  DepthMap depth{stereo.camera, cv::Mat1f(px128.size()), cv::Mat1f(px128.size())};
  // Without branches, so that it runs over whole vectors (bench `wire`, `pipeline.realtime_factor`).
  for (int v = 0; v < px128.rows; ++v) {
    const std::uint16_t* units = px128[v];
    const float* sigma = sigma_px[v];
    float* __restrict depth_m = depth.depth_m[v];
    float* __restrict sigma_m = depth.sigma_m[v];
    for (int u = 0; u < px128.cols; ++u) {
      const bool given = units[u] != kMissing && units[u] != 0;
      const float z = Bf * kUnitsPerPixel / static_cast<float>(given ? units[u] : 1);  // eq. A.12
      const bool used = given && z >= nearest_m && z <= farthest_m;
      depth_m[u] = used ? z : 0.0F;
      sigma_m[u] = used ? z * z * sigma[u] / Bf : 0.0F;
    }
  }
  return depth;
}

}  // namespace arpent::stereo
