// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Which disparities a pixel of the next pyramid level may take: around the prior and around what was matched in its
// neighbourhood (the union of the ELAS paper's plane prior and its neighbouring support disparities, sect. 3.3), as two
// bands. Where the neighbourhood is one surface, the bands lie side by side; at an edge one follows the nearer surface
// and one the farther.
#pragma once

#include <opencv2/core.hpp>

#include "perception/stereo/elas/level.h"

namespace arpent::stereo {

/// `px128`: a disparity for every pixel of this level; `prior`: of the same size, kMissing where there is none. `next`
/// is the size of the next level, twice this level's (one more if odd). Candidates are at most `range_px` - 1.
[[nodiscard]] CandidateGrid propose_candidates(const cv::Mat1w& px128, const cv::Mat1w& prior, const cv::Size& next,
                                               int range_px);

}  // namespace arpent::stereo
