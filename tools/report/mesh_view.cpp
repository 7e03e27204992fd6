// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/report/mesh_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <tuple>

namespace arpent::report {
namespace {

constexpr float kNearM = 0.05F;
const cv::Vec3b kPaper(255, 255, 255);

struct Raster {
  cv::Mat1f depth_m;
  cv::Mat1i triangle;
};

/// Fills one projected triangle (u, v, z) with a z-buffer; depth is interpolated as 1/z.
void fill(Raster& raster, const std::array<Eigen::Vector3f, 3>& p, int index) {
  const float area = (p[1].x() - p[0].x()) * (p[2].y() - p[0].y()) - (p[2].x() - p[0].x()) * (p[1].y() - p[0].y());
  if (std::abs(area) < 1e-9F) return;
  const auto [u_low, u_high] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
  const auto [v_low, v_high] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
  if (u_high < 0 || v_high < 0 || u_low > static_cast<float>(raster.depth_m.cols) ||
      v_low > static_cast<float>(raster.depth_m.rows))
    return;
  const int u0 = std::max(0, static_cast<int>(std::ceil(u_low))),
            u1 = std::min(raster.depth_m.cols - 1, static_cast<int>(u_high));
  const int v0 = std::max(0, static_cast<int>(std::ceil(v_low))),
            v1 = std::min(raster.depth_m.rows - 1, static_cast<int>(v_high));
  for (int v = v0; v <= v1; ++v) {
    for (int u = u0; u <= u1; ++u) {
      const auto fu = static_cast<float>(u), fv = static_cast<float>(v);
      const float a = ((p[1].x() - fu) * (p[2].y() - fv) - (p[2].x() - fu) * (p[1].y() - fv)) / area;
      const float b = ((p[2].x() - fu) * (p[0].y() - fv) - (p[0].x() - fu) * (p[2].y() - fv)) / area;
      const float c = 1 - a - b;
      if (a < 0 || b < 0 || c < 0) continue;
      const float z = 1.0F / (a / p[0].z() + b / p[1].z() + c / p[2].z());
      float& nearest = raster.depth_m(v, u);
      if (nearest > 0 && nearest <= z) continue;
      nearest = z;
      raster.triangle(v, u) = index;
    }
  }
}

Raster rasterise(const TriangleMesh& mesh, const PinholeCamera& camera, const Pose& T_map_cam) {
  Raster raster{cv::Mat1f(camera.height_px, camera.width_px, 0.0F), cv::Mat1i(camera.height_px, camera.width_px, -1)};
  const Eigen::Isometry3f T_cam_map = T_map_cam.inverse().cast<float>();
  std::vector<Eigen::Vector3f> projected;
  projected.reserve(mesh.vertices_m.size());
  for (const auto& p_map : mesh.vertices_m) {
    const Eigen::Vector3f p = T_cam_map * p_map;
    projected.emplace_back(static_cast<float>(camera.fx_px) * p.x() / p.z() + static_cast<float>(camera.cx_px),
                           static_cast<float>(camera.fy_px) * p.y() / p.z() + static_cast<float>(camera.cy_px), p.z());
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const std::array<Eigen::Vector3f, 3> p{projected[a], projected[b], projected[c]};
    // Triangles that reach behind the camera are left out: they are small.
    if (p[0].z() < kNearM || p[1].z() < kNearM || p[2].z() < kNearM) continue;
    fill(raster, p, static_cast<int>(i));
  }
  return raster;
}

Eigen::Vector3f normal_of(const TriangleMesh& mesh, std::size_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return (mesh.vertices_m[b] - mesh.vertices_m[a]).cross(mesh.vertices_m[c] - mesh.vertices_m[a]).normalized();
}

cv::Vec3b height_color(float share) {
  cv::Mat1b level(1, 1, static_cast<std::uint8_t>(std::clamp(30.0F + 200.0F * share, 0.0F, 255.0F)));
  cv::Mat3b color;
  cv::applyColorMap(level, color, cv::COLORMAP_VIRIDIS);
  return color(0, 0);
}

/// Extent of a coordinate without the outermost percent.
std::pair<float, float> extent(const TriangleMesh& mesh, int axis) {
  std::vector<float> values;
  for (const auto& p : mesh.vertices_m) values.push_back(p[axis]);
  const std::size_t cut = values.size() / 100;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(cut), values.end());
  const float low = values[cut];
  std::nth_element(values.begin(), values.end() - 1 - static_cast<std::ptrdiff_t>(cut), values.end());
  return {low, values[values.size() - 1 - cut]};
}

/// What the mesh says that the triangle looks like.
std::optional<cv::Vec3b> own_color(const TriangleMesh& mesh, int triangle) {
  if (mesh.colors_rgb.empty()) return std::nullopt;
  const auto& rgb = mesh.colors_rgb[mesh.triangles[static_cast<std::size_t>(triangle)][0]];
  return cv::Vec3b(rgb[2], rgb[1], rgb[0]);
}

cv::Mat3b shade(const TriangleMesh& mesh, const Raster& raster, const Pose& T_map_cam) {
  cv::Mat3b picture(raster.depth_m.size(), kPaper);
  if (mesh.vertices_m.empty()) return picture;
  const auto [low, high] = extent(mesh, 2);
  const Eigen::Vector3f view = T_map_cam.linear().col(2).cast<float>();
  const Eigen::Vector3f light = Eigen::Vector3f(0.35F, -0.5F, 0.8F).normalized();
  std::array<cv::Vec3b, 64> colors;
  for (std::size_t i = 0; i < colors.size(); ++i) colors[i] = height_color(static_cast<float>(i) / 63.0F);
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      const int index = raster.triangle(v, u);
      if (index < 0) continue;
      const Eigen::Vector3f n = normal_of(mesh, static_cast<std::size_t>(index));
      const float z = mesh.vertices_m[mesh.triangles[static_cast<std::size_t>(index)][0]].z();
      const float share = std::clamp((z - low) / std::max(0.1F, high - low), 0.0F, 1.0F);
      const float brightness = 0.45F + 0.35F * std::abs(n.dot(light)) + 0.2F * std::abs(n.dot(view));
      const cv::Vec3b color = own_color(mesh, index).value_or(colors[static_cast<std::size_t>(share * 63)]);
      for (int k = 0; k < 3; ++k)
        picture(v, u)[k] = static_cast<std::uint8_t>(std::min(255.0F, brightness * static_cast<float>(color[k])));
    }
  }
  return picture;
}

void draw_path(cv::Mat3b& picture, const ViewPath& path, const PinholeCamera& camera, const Pose& T_cam_map) {
  std::vector<cv::Point> line;
  for (const auto& p_map : path.points_m) {
    const Eigen::Vector3d p = T_cam_map * p_map;
    if (p.z() < kNearM) continue;
    const Eigen::Vector2d pixel = camera.project(p);
    if (pixel.cwiseAbs().maxCoeff() < 1e5) line.emplace_back(cvRound(4 * pixel.x()), cvRound(4 * pixel.y()));
  }
  cv::polylines(picture, line, false, path.color_bgr, 2, cv::LINE_AA, 2);
}

struct View {
  PinholeCamera camera;
  Pose T_map_cam = Pose::Identity();
};

/// From above at a slant, so that the box fills the picture.
View birds_eye(const Eigen::AlignedBox3f& box, cv::Size size) {
  const Eigen::Vector3d extent = box.sizes().cast<double>();
  // The longer side of the map lies along the picture; the camera looks down at 55 degrees from far away, nearly
  // without perspective.
  const double yaw = extent.x() >= extent.y() ? std::numbers::pi / 2 : 0.0;
  const double pitch = 55.0 * std::numbers::pi / 180.0;
  const Eigen::Vector3d forward(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), -std::sin(pitch));
  const Eigen::Vector3d right(std::sin(yaw), -std::cos(yaw), 0);
  View view;
  view.T_map_cam.linear() << right, forward.cross(right), forward;
  view.T_map_cam.translation() = box.center().cast<double>() - 3 * extent.norm() * forward;
  double widest = 1e-9;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3f p_map = box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(corner));
    const Eigen::Vector3d p = view.T_map_cam.inverse() * Eigen::Vector3d(p_map.cast<double>());
    widest = std::max(
        {widest, std::abs(p.x() / p.z()) / (0.47 * size.width), std::abs(p.y() / p.z()) / (0.47 * size.height)});
  }
  view.camera = {size.width, size.height, 1 / widest, 1 / widest, 0.5 * size.width, 0.5 * size.height};
  return view;
}

cv::Mat3b draw(const TriangleMesh& mesh, const std::vector<ViewPath>& paths, const View& view) {
  cv::Mat3b picture = shade(mesh, rasterise(mesh, view.camera, view.T_map_cam), view.T_map_cam);
  for (const ViewPath& path : paths) draw_path(picture, path, view.camera, view.T_map_cam.inverse());
  return picture;
}

}  // namespace

cv::Mat3b draw_birds_eye(const TriangleMesh& mesh, const std::vector<ViewPath>& paths, cv::Size size) {
  if (mesh.vertices_m.size() < 3) return cv::Mat3b(size, kPaper);
  Eigen::AlignedBox3f box;
  for (int axis = 0; axis < 3; ++axis) std::tie(box.min()[axis], box.max()[axis]) = extent(mesh, axis);
  return draw(mesh, paths, birds_eye(box, size));
}

cv::Mat3b draw_open(const TriangleMesh& mesh, const std::vector<ViewPath>& paths, const Eigen::AlignedBox3f& box_m,
                    cv::Size size) {
  const View view = birds_eye(box_m, size);
  const Eigen::Vector3f eye = view.T_map_cam.translation().cast<float>();
  TriangleMesh facing = mesh;
  std::erase_if(facing.triangles, [&](const std::array<std::uint32_t, 3>& t) {
    const Eigen::Vector3f &a = mesh.vertices_m[t[0]], &b = mesh.vertices_m[t[1]], &c = mesh.vertices_m[t[2]];
    return (b - a).cross(c - a).dot(eye - a) <= 0;
  });
  return draw(facing, paths, view);
}

cv::Mat3b draw_from_camera(const TriangleMesh& mesh, const PinholeCamera& camera, const Pose& T_map_cam) {
  return shade(mesh, rasterise(mesh, camera, T_map_cam), T_map_cam);
}

cv::Mat1f render_depth(const TriangleMesh& mesh, const PinholeCamera& camera, const Pose& T_map_cam) {
  return rasterise(mesh, camera, T_map_cam).depth_m;
}

}  // namespace arpent::report
