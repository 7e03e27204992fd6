// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A picture of a mesh, drawn in software: shaded by its normals, coloured by height or as it
// says itself, with paths laid over it.
#pragma once

#include <Eigen/Geometry>
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
/// The same from outside and above into rooms: what faces away from the viewer (ceilings, the near walls) is left out.
/// The view shows the box, so that pictures of a growing map fit upon each other.
[[nodiscard]] cv::Mat3b draw_open(const TriangleMesh& mesh, const std::vector<ViewPath>& paths,
                                  const Eigen::AlignedBox3f& box_m, cv::Size size);
/// What a camera at `T_map_cam` sees of the mesh.
[[nodiscard]] cv::Mat3b draw_from_camera(const TriangleMesh& mesh, const PinholeCamera& camera, const Pose& T_map_cam);
/// Depth [m] of the mesh seen from a camera; 0 where nothing is hit.
[[nodiscard]] cv::Mat1f render_depth(const TriangleMesh& mesh, const PinholeCamera& camera, const Pose& T_map_cam);

}  // namespace arpent::report
