// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Readings <-> imu_t.
#pragma once

#include <arpent/imu_t.hpp>

#include "common/result.h"
#include "drivers/imu/iio_imu.h"

namespace arpent::imu {

[[nodiscard]] imu_t to_wire(const Reading& reading, std::int64_t sequence);
/// A fault if a number is not finite or the sequence negative.
[[nodiscard]] Result<Reading> from_wire(const imu_t& message);

}  // namespace arpent::imu
