// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The baseline matcher: OpenCV's semi-global matching, with both images padded to the left by the disparity range so
// that the left columns are matched too. It is what a user would pick instead of ours; benchmarks compare with it.
#pragma once

#include <memory>

#include "perception/stereo/matcher.h"

namespace arpent::stereo {

[[nodiscard]] std::unique_ptr<StereoMatcher> make_sgbm_matcher(const MatcherParams& params);

}  // namespace arpent::stereo
