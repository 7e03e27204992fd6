// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Makes a robot's patches: integrates its own depth images, a few at a time, each lot into an empty map, and codes that
// map once the lot is full. What others saw never gets in, so nothing is counted twice.
#pragma once

#include <optional>
#include <vector>

#include "common/config/fields.h"
#include "mapping/exchange/map_patch.h"

namespace arpent::mapping {

struct PatchParams {
  int images = 5;
  int max_still_images = 20;
  int max_bytes = 7500;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("images", self.images, "depth images in a patch", config::between(1, 1000));
    visitor.field("max_still_images", self.max_still_images,
                  "of a robot that stands, no more than so many images from one place are used", config::at_least(1));
    visitor.field("max_bytes", self.max_bytes, "largest sample, before the message around it",
                  config::between(2048, 60000));
  }
};

/// A depth image with what belongs to it.
struct PosedDepth {
  Time stamp;
  const stereo::DepthMap& depth;
  Pose T_map_cam;
  Pose2 body;
  double position_sigma_m = 0;
  double heading_sigma_rad = 0;
};

class PatchBuilder {
 public:
  /// Throws InputError for parameters that break their rules.
  PatchBuilder(const PatchParams& params, const TsdfParams& tsdf, const std::string& source, const std::string& frame);

  /// The samples of a patch if this image completed one, else none.
  [[nodiscard]] std::vector<MapPatch> add(const PosedDepth& image);

 private:
  [[nodiscard]] bool stands_too_long(const Pose2& body);
  [[nodiscard]] std::vector<MapPatch> close();

  PatchParams params_;
  TsdfParams tsdf_;
  TsdfMap open_;
  MapPatch head_;  ///< of the open patch: everything but its blocks
  Pose2 stood_at_;
  int still_images_ = 0;
};

}  // namespace arpent::mapping
