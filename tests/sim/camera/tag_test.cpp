// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The tag cube as the AprilTag library's own detector sees it.
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/sim/camera/scenes.h"

namespace arpent::sim {
namespace {

using Corners = std::array<Eigen::Vector2d, 4>;

std::map<int, Corners> detect(const cv::Mat1b& image) {
  apriltag_family_t* family = tag36h11_create();
  apriltag_detector_t* detector = apriltag_detector_create();
  apriltag_detector_add_family(detector, family);
  detector->quad_decimate = 1;
  image_u8_t view = {image.cols, image.rows, static_cast<std::int32_t>(image.step), image.data};
  zarray_t* found = apriltag_detector_detect(detector, &view);
  std::map<int, Corners> tags;
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* tag = nullptr;
    zarray_get(found, i, &tag);
    // The detector has pixel centres at halves.
    for (std::size_t k = 0; k < 4; ++k) tags[tag->id][k] = Eigen::Vector2d(tag->p[k][0] - 0.5, tag->p[k][1] - 0.5);
  }
  apriltag_detections_destroy(found);
  apriltag_detector_destroy(detector);
  tag36h11_destroy(family);
  return tags;
}

TEST(Tags, FromEveryStartTheDetectorFindsThemWhereTheWorldFileSays) {
  RawCamera raw;
  raw.pinhole = {640, 512, 377, 377, 319.5, 255.5};
  const CameraModel camera(raw);
  for (const std::string name : {"test_arena", "parking_lot"}) {
    const World world = load_world(ARPENT_SOURCE_DIR "/config/worlds/" + name + ".yaml");
    const Renderer renderer(world);
    for (const Pose2& start : world.starts) {
      const Pose T_world_cam = start.to_pose() * looking_along_x({0.20, 0.13, 0.40});
      const auto found = detect(renderer.render(camera, T_world_cam, {}).image);
      EXPECT_FALSE(found.empty()) << name << " from (" << start.x_m << ", " << start.y_m << ")";
      for (const PlacedTag& tag : placed_tags(*world.tag_cube)) {
        if (!found.contains(tag.id)) continue;
        for (std::size_t k = 0; k < 4; ++k) {
          const Eigen::Vector2d expected = raw.pinhole.project(T_world_cam.inverse() * tag.corners_m[k]);
          EXPECT_LT((found.at(tag.id)[k] - expected).norm(), 0.6) << name << " tag " << tag.id << " corner " << k;
        }
      }
    }
  }
}

TEST(Tags, PosesAgreeWithCorners) {
  TagCube cube;
  cube.centre_m = {1, 2, 0.4};
  cube.yaw_rad = 0.3;
  for (const PlacedTag& tag : placed_tags(cube)) {
    const Pose& T = tag.T_world_tag;
    EXPECT_NEAR(T.linear().determinant(), 1, 1e-12);
    EXPECT_LT((T * Eigen::Vector3d(-0.12, 0.12, 0) - tag.corners_m[0]).norm(), 1e-12) << "bottom left";
    EXPECT_LT((T * Eigen::Vector3d(0.12, -0.12, 0) - tag.corners_m[2]).norm(), 1e-12) << "top right";
    EXPECT_LT((T * Eigen::Vector3d(0, 0, 0.15) - cube.centre_m).norm(), 1e-12) << "z into the cube";
  }
}

}  // namespace
}  // namespace arpent::sim
