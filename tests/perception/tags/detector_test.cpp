// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/detector.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "tests/perception/tags/cube_pictures.h"

namespace arpent::tags {
namespace {

TEST(TagDetector, FindsTheFaceThatIsSeenWithItsCornersInOrder) {
  const TagCubeConfig config;
  const TagCube cube(config);
  const TagDetector detector({});
  Eigen::Vector2d bias(0, 0);
  for (int face = 0; face < 4; ++face) {
    const Pose pose = pose_facing(config, 1.5, face * M_PI / 2 + 0.2, 0.05);
    const auto pair = render_cube(config, pose, static_cast<std::uint64_t>(face));
    const auto tags = detector.detect(pair.left);
    ASSERT_FALSE(tags.empty());
    const auto found = std::find_if(tags.begin(), tags.end(), [&](const auto& t) { return t.id == face; });
    ASSERT_NE(found, tags.end());
    EXPECT_EQ(found->hamming, 0);
    const Pose T_cam_world = (pose * make_T_body_cam()).inverse();
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d error =
          found->corners_px[k] - make_stereo().camera.project(T_cam_world * (*cube.find_corners(face))[k]);
      EXPECT_LT(error.norm(), 1.0) << "face " << face << " corner " << k;
      bias += error / 16;
    }
  }
  EXPECT_LT(bias.norm(), 0.2) << "pixel centres are whole numbers";
}

TEST(TagDetector, APartOfTheImageGivesTheSameTag) {
  const auto pair = render_cube({}, pose_facing({}, 2.0, 0.0, 0.0), 3);
  DetectorParams params;
  params.decimate = 1;
  const TagDetector detector(params);
  const auto whole = detector.detect(pair.left);
  ASSERT_EQ(whole.size(), 1U);
  const auto part = detector.detect_in(pair.left, {220, 190, 160, 130});
  ASSERT_EQ(part.size(), 1U);
  EXPECT_EQ(part[0].id, whole[0].id);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_LT((part[0].corners_px[k] - whole[0].corners_px[k]).norm(), 0.5);
  EXPECT_TRUE(detector.detect_in(pair.left, {630, 500, 100, 100}).empty()) << "hardly any of it is in the image";
  EXPECT_TRUE(detector.detect_in(pair.left, {900, 0, 50, 50}).empty());
}

TEST(TagDetector, SeesNoTagsWhereThereAreNone) {
  PictureOptions options;
  options.with_cube = false;
  const TagDetector detector({});
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    options.noise_levels = seed % 2 == 0 ? 1.5 : 25;
    EXPECT_TRUE(detector.detect(render_cube({}, Pose::Identity(), seed, options).left).empty()) << seed;
  }
}

/// The public photos of the AprilTag library with the tags that its authors list.
TEST(TagDetector, FindsAllTagsOfThePublicPhotosAndNoOther) {
  const char* data = std::getenv("ARPENT_DATA");
  if (data == nullptr) GTEST_SKIP() << "ARPENT_DATA is not set";
  const std::filesystem::path folder = std::filesystem::path(data) / "stereo/apriltag/aprilrobotics";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  DetectorParams params;
  params.decimate = 1;
  params.max_hamming = 2;
  params.min_decision_margin = 0;
  const TagDetector detector(params);
  int expected = 0, found = 0, false_ones = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".jpg") continue;
    std::ifstream list(std::filesystem::path(entry.path()).replace_extension(".txt"));
    std::vector<Eigen::Vector2d> centres;
    for (std::string line; std::getline(list, line);) {
      int id = 0;
      double p[8];
      ASSERT_EQ(std::sscanf(line.c_str(), "%d, (%lf %lf), (%lf %lf), (%lf %lf), (%lf %lf)", &id, p, p + 1, p + 2, p + 3,
                            p + 4, p + 5, p + 6, p + 7),
                9);
      EXPECT_EQ(id, 0);
      centres.emplace_back((p[0] + p[2] + p[4] + p[6]) / 4, (p[1] + p[3] + p[5] + p[7]) / 4);
    }
    expected += static_cast<int>(centres.size());
    for (const TagDetection& tag : detector.detect(cv::imread(entry.path().string(), cv::IMREAD_GRAYSCALE))) {
      const Eigen::Vector2d centre =
          (tag.corners_px[0] + tag.corners_px[1] + tag.corners_px[2] + tag.corners_px[3]) / 4;
      const auto listed = std::find_if(centres.begin(), centres.end(),
                                       [&](const Eigen::Vector2d& c) { return (c - centre).norm() < 3; });
      const bool right = tag.id == 0 && listed != centres.end();
      right ? ++found : ++false_ones;
      if (right) centres.erase(listed);
    }
  }
  EXPECT_EQ(expected, 47);
  EXPECT_EQ(found, 47);
  EXPECT_EQ(false_ones, 0);
}

}  // namespace
}  // namespace arpent::tags
