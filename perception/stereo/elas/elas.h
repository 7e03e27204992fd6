// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The stereo matcher of the robots, after ELAS (Geiger, Roser and Urtasun, ACCV 2010; thesis App. A.2.2): few sure
// matches span a piecewise planar prior, and the dense search looks only around it and around what the neighbourhood
// matched, so that the cost hardly depends on the disparity range. Unlike the paper, the support points come from a
// small image matched over its whole range, and the dense search minimises over a neighbourhood, not pixel by pixel;
// docs/decisions/0003 says what each step gains.
#pragma once

#include <memory>

#include "perception/stereo/matcher.h"

namespace arpent::stereo {

[[nodiscard]] std::unique_ptr<StereoMatcher> make_elas_matcher(const MatcherParams& params);

}  // namespace arpent::stereo
