// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/matcher.h"

#include "common/config/config.h"
#include "perception/stereo/elas/elas.h"
#include "perception/stereo/sgbm.h"

namespace arpent::stereo {

std::unique_ptr<StereoMatcher> make_matcher(const MatcherParams& params) {
  config::check(params, "stereo matcher");
  if (params.algorithm == "elas") return make_elas_matcher(params);
  return make_sgbm_matcher(params);
}

}  // namespace arpent::stereo
