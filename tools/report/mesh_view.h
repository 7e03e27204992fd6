// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A picture of a mesh, drawn in software: shaded by its normals, coloured by height, with paths laid over it.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "common/camera.h"
#include "common/mesh.h"

namespace arpent::report {

struct ViewPath {
  std::vector<Eigen::Vector3d> points_m;
  cv::Scalar color_bgr;
};

/// A view from above at a slant that shows the whole mesh (outliers apart). White where there is nothing; an empty mesh
/// gives a white picture.
[[nodiscard]] cv::Mat3b draw_birds_eye(const TriangleMesh& mesh, const std::vector<ViewPath>& paths, cv::Size size);
/// What a camera at `T_map_cam` sees of the mesh.
[[nodiscard]] cv::Mat3b draw_from_camera(const TriangleMesh& mesh, const PinholeCamera& camera, const Pose& T_map_cam);
/// Depth [m] of the mesh seen from a camera; 0 where nothing is hit.
[[nodiscard]] cv::Mat1f render_depth(const TriangleMesh& mesh, const PinholeCamera& camera, const Pose& T_map_cam);

}  // namespace arpent::report
