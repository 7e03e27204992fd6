// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Pictures of the tag cube for tests and benchmark: ray traced with supersampling in front of clutter, with the lens'
// blur, motion blur, vignetting and noise. The tags' patterns are libapriltag's own; the truth is exact.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "common/camera.h"
#include "perception/tags/cube.h"

namespace arpent::tags {

struct PictureOptions {
  double noise_levels = 1.5;   ///< Gaussian, standard deviation
  double lens_sigma_px = 0.5;  ///< Gaussian blur on top of the pixel's own area
  double motion_px = 0;        ///< length of a horizontal smear
  double light = 1.0;          ///< of everything
  bool with_cube = true;
  double true_tag_m = 0.24;         ///< what is painted, whatever the config says
  std::vector<double> painted_ids;  ///< if not empty: what is painted, whatever the config says
  /// A card on every face, its extent as shares of the tag's width and height from its left and bottom.
  double card_left = 0, card_right = 0, card_bottom = 0, card_top = 0;
  double card_grey = 110;
};

struct CubePair {
  Pose T_world_body;
  cv::Mat1b left, right;
};

/// The rig of config/rigs, rectified.
[[nodiscard]] RectifiedStereo make_stereo();
[[nodiscard]] Pose make_T_body_cam();

/// `seed` makes noise, clutter and the faces' light; equal arguments give equal bytes.
[[nodiscard]] CubePair render_cube(const TagCubeConfig& cube, const Pose& T_world_body, std::uint64_t seed,
                                   const PictureOptions& options = {});

/// A pose on the ground from which both cameras see the cube, its rig `range_m` from the cube's centre at `bearing_rad`
/// (direction from the cube, in the cube's frame), looking past the centre by `offset_rad`.
[[nodiscard]] Pose pose_facing(const TagCubeConfig& cube, double range_m, double bearing_rad, double offset_rad);

}  // namespace arpent::tags
