// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/cube.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>

#include "common/config/config.h"
#include "common/error.h"

namespace arpent::tags {
namespace {

using Eigen::Vector3d;

TEST(TagCube, TheCornersOfTheFirstFaceAreWhereOneComputesThemByHand) {
  TagCubeConfig config;
  config.x_m = 1;
  config.y_m = 2;
  config.z_m = 0.4;
  const TagCube cube(config);
  const TagCorners& corners = *cube.find_corners(0);
  // The face +x lies at x = 1 + 0.15; who looks at it, towards -x, has +y on his right.
  EXPECT_TRUE(corners[0].isApprox(Vector3d(1.15, 1.88, 0.28)));
  EXPECT_TRUE(corners[1].isApprox(Vector3d(1.15, 2.12, 0.28)));
  EXPECT_TRUE(corners[2].isApprox(Vector3d(1.15, 2.12, 0.52)));
  EXPECT_TRUE(corners[3].isApprox(Vector3d(1.15, 1.88, 0.52)));
}

TEST(TagCube, EachFaceIsAnUprightSquareThatLooksOutwards) {
  TagCubeConfig config;
  config.yaw_rad = 0.7;
  config.ids = {17, 4, 586, 9};
  const TagCube cube(config);
  const Vector3d centre(config.x_m, config.y_m, config.z_m);
  for (std::size_t face = 0; face < 4; ++face) {
    const TagCorners& c = *cube.find_corners(static_cast<int>(config.ids[face]));
    const Vector3d right = c[1] - c[0];
    const Vector3d up = c[3] - c[0];
    EXPECT_NEAR(right.norm(), 0.24, 1e-12);
    EXPECT_TRUE(up.isApprox(Vector3d(0, 0, 0.24)));
    EXPECT_TRUE((c[2] - c[1]).isApprox(up));
    const Vector3d outward = right.cross(up).normalized();
    const double heading_rad = 0.7 + static_cast<double>(face) * M_PI / 2;
    EXPECT_TRUE(outward.isApprox(Vector3d(std::cos(heading_rad), std::sin(heading_rad), 0))) << face;
    EXPECT_TRUE((0.5 * (c[0] + c[2])).isApprox(centre + 0.15 * outward));
  }
  EXPECT_EQ(cube.find_corners(0), nullptr) << "not one of its ids";
}

TEST(TagCube, RefusesWhatCannotBe) {
  const auto refusal = [](const std::string& yaml) {
    try {
      (void)TagCube(config::load_text<TagCubeConfig>("cube.yaml", yaml));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal("{x_m: 3.4, y_m: 7.0, ids: [5, 6, 7, 8]}"), "");
  EXPECT_THAT(refusal("ids: [1, 2, 3]"), testing::HasSubstr("four different whole numbers"));
  EXPECT_THAT(refusal("ids: [1, 2, 3, 3]"), testing::HasSubstr("four different whole numbers"));
  EXPECT_THAT(refusal("ids: [1, 2, 3, 4.5]"), testing::HasSubstr("four different whole numbers"));
  EXPECT_THAT(refusal("ids: [1, 2, 3, 587]"), testing::HasSubstr("four different whole numbers"));
  EXPECT_THAT(refusal("tag_m: 0.31"), testing::HasSubstr("does not fit its face"));
  EXPECT_THAT(refusal("edge_m: 0"), testing::HasSubstr("> 0"));
}

}  // namespace
}  // namespace arpent::tags
