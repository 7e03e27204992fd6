// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Where the least squares start: many focal lengths are tried, each with all cameras at once. A single camera that sees
// nearly the same view all the time has minima whose focal length is wrong by a factor; what the other camera sees of
// the same board at the same time tells them apart.
#pragma once

#include <vector>

#include "calib/rig_problem.h"
#include "calib/views.h"

namespace arpent::calib {

[[nodiscard]] std::vector<Observation> to_observations(const BoardViews& views);

/// The best of all starts, with distortion, fitted to a part of the views, and poses for all views. Throws InputError
/// if no start leads anywhere.
[[nodiscard]] RigEstimate initial_estimate(const BoardViews& views, DistortionModel model);

/// `cameras` (lenses and places) with the boards of `views` found anew.
[[nodiscard]] RigEstimate place_boards_of(const BoardViews& views, const RigEstimate& cameras);

}  // namespace arpent::calib
