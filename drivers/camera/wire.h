// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Pairs of the camera driver -> stereo_images_t. Whoever receives them decodes with perception/stereo/wire.h.
#pragma once

#include <arpent/stereo_images_t.hpp>

#include "drivers/camera/pairer.h"

namespace arpent::camera {

/// Both images raw. The exposure and gain are the left image's; the process counts pairs in which they differ.
[[nodiscard]] stereo_images_t to_wire(const FramePair& pair);

}  // namespace arpent::camera
