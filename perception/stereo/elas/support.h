// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Support points and the prior that they span: sure matches on a sparse grid, joined by a Delaunay triangulation into a
// piecewise planar surface (Geiger, Roser and Urtasun, "Efficient large-scale stereo matching", ACCV 2010, sect. 3.1
// and 3.2). The prior carries disparities across areas that match nothing by themselves.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "perception/stereo/elas/level.h"

namespace arpent::stereo {

struct SupportPoint {
  int u;
  int v;
  std::uint16_t px128;
};

/// The sharpest match of each 5 x 5 cell; cells without a consistent and
/// unambiguous one have none.
[[nodiscard]] std::vector<SupportPoint> select_support_points(const LevelMatch& match);

/// Disparity of the triangulated surface at each pixel of an image of `size`, 1/128 px; kMissing outside of the
/// triangles (thin slivers along the convex hull are left out), and everywhere with fewer than three points.
[[nodiscard]] cv::Mat1w interpolate_prior(const std::vector<SupportPoint>& points, const cv::Size& size);

}  // namespace arpent::stereo
