// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The feeds that a configuration asks for.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "drivers/camera/process/camera_process.h"

namespace arpent {

/// Left and right, or one whose frames hold both. Throws InputError for a configuration that can never work.
[[nodiscard]] std::vector<std::unique_ptr<camera::Feed>> open_feeds(const CameraConfig& config, Clock& clock);

}  // namespace arpent
