// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages <-> types of tags: tag_observation_t (tag_t inside) and frame_alignment_t.
#pragma once

#include <arpent/frame_alignment_t.hpp>
#include <arpent/tag_observation_t.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/time.h"
#include "perception/tags/alignment.h"
#include "perception/tags/observer.h"

namespace arpent::tags {

/// What an observation tells others: the tags, and the body's pose on the ground if it is accepted.
struct BodyObservation {
  Time stamp;
  std::int64_t sequence = 0;
  std::vector<TagDetection> tags;
  bool accepted = false;
  std::string reason;  ///< why not
  Pose T_world_body = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< (translation [m], rotation [rad]) in body axes
};

[[nodiscard]] BodyObservation to_body(Time stamp, std::int64_t sequence, const Observation& observation);

[[nodiscard]] tag_observation_t to_wire(const BodyObservation& observation);
/// Checks frames, counts, ids, finiteness, the unit quaternion and, of an accepted one, positive variances.
[[nodiscard]] Result<BodyObservation> from_wire(const tag_observation_t& message);

[[nodiscard]] frame_alignment_t to_wire(const Alignment& alignment);
/// Checks frames, finiteness, the unit quaternion, positive variances and the number of views. `ground_chi2` is not on
/// the wire.
[[nodiscard]] Result<Alignment> from_wire(const frame_alignment_t& message);

}  // namespace arpent::tags
