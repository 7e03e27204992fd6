// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The footprints of two robots against each other.
#pragma once

#include "common/pose2.h"

namespace arpent {

/// Whether the ellipses of two robots at these poses (semi-axes along and across their headings) have a point in
/// common; exact to a few micrometres.
[[nodiscard]] bool ellipses_overlap(double semi_long_m, double semi_short_m, const Pose2& a, const Pose2& b);

}  // namespace arpent
