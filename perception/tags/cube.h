// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The calibration cube that defines the world frame (thesis Sect. 5.2.2): where it stands, and where the corners of its
// four tags are. Tags of family 36h11, one upright in the middle of each side face; a world file states the same
// values.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "common/config/fields.h"

namespace arpent::tags {

/// Tags of family 36h11 have ids 0 to 586.
inline constexpr int kFamilySize = 587;

namespace detail {
[[nodiscard]] config::Rule<std::vector<double>> four_tag_ids();
}  // namespace detail

struct TagCubeConfig {
  double x_m = 2.2;
  double y_m = 3.5;
  double z_m = 0.4;
  double yaw_rad = 0;
  double edge_m = 0.30;
  double tag_m = 0.24;
  std::vector<double> ids{0, 1, 2, 3};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("x_m", self.x_m, "centre of the cube in the world");
    visitor.field("y_m", self.y_m, "the same");
    visitor.field("z_m", self.z_m, "the same, above the ground");
    visitor.field("yaw_rad", self.yaw_rad, "heading of the cube's x axis");
    visitor.field("edge_m", self.edge_m, "edge of the cube", config::greater_than(0.0));
    visitor.field("tag_m", self.tag_m, "edge of a tag: of its black square, without the white rim",
                  config::greater_than(0.0));
    visitor.field("ids", self.ids, "tags on the faces +x, +y, -x, -y of the cube", detail::four_tag_ids());
  }
};

/// The corners of one tag [m], in the order of the detector: bottom left, bottom right, top right, top left as one
/// looks at the tag.
using TagCorners = std::array<Eigen::Vector3d, 4>;

class TagCube {
 public:
  /// Throws InputError if a rule of the config does not hold or a tag is larger than its face.
  explicit TagCube(const TagCubeConfig& config);

  /// The corners of tag `id` in the world; nullptr if the cube does not carry it.
  [[nodiscard]] const TagCorners* find_corners(int id) const;
  /// Ids and corners in the order of the faces.
  [[nodiscard]] const std::array<int, 4>& ids() const { return ids_; }
  [[nodiscard]] double tag_m() const { return tag_m_; }

 private:
  std::array<int, 4> ids_{};
  std::array<TagCorners, 4> corners_world_m_;
  double tag_m_ = 0;
};

}  // namespace arpent::tags
