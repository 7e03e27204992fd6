// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a camera in a world sees: a grey picture and the exact depth. Rays are traced through the pixels' centres;
// surfaces are shaded from filtered textures and baked light; where surfaces meet, eight rays share a pixel.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <span>

#include "sim/camera/camera_model.h"
#include "sim/world/world.h"

namespace arpent::sim {

/// A robot that other robots see: chassis, wheels and a bar with its cameras (they are the size of the thesis' robots).
struct Body {
  Pose T_world_body = Pose::Identity();
};

struct CameraImage {
  cv::Mat1b image;
  cv::Mat1f depth_m;  ///< along the optical axis, exact for the pixel's centre; 0 where nothing is hit
};

class Renderer {
 public:
  /// Builds the ray tracer and the textures and computes the light: 0.1 to 3 s.
  explicit Renderer(const World& world);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// The same arguments give the same bytes. May be called by several threads. `bodies`: the *other* robots.
  [[nodiscard]] CameraImage render(const CameraModel& camera, const Pose& T_world_cam, const CameraShot& shot,
                                   std::span<const Body> bodies = {}) const;

  /// The depth of render() alone, without what it takes to make a picture.
  [[nodiscard]] cv::Mat1f depth_m(const CameraModel& camera, const Pose& T_world_cam,
                                  std::span<const Body> bodies = {}) const;

  /// Light that falls on the world's surface at the end of a ray from `from_m`, in units of Lighting::mean; nullopt if
  /// the ray hits nothing.
  [[nodiscard]] std::optional<double> irradiance(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction) const;

 private:
  struct Scene;
  std::unique_ptr<const Scene> scene_;
};

}  // namespace arpent::sim
