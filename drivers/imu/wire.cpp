// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/wire.h"

namespace arpent::imu {

imu_t to_wire(const Reading& reading, std::int64_t sequence) {
  imu_t message{};
  message.utime = to_utime(reading.stamp);
  message.sequence = sequence;
  for (int i = 0; i < 3; ++i) {
    message.angular_velocity_radps[i] = reading.angular_velocity_radps[i];
    message.acceleration_mps2[i] = reading.acceleration_mps2[i];
  }
  return message;
}

Result<Reading> from_wire(const imu_t& message) {
  const Reading reading{from_utime(message.utime), Eigen::Vector3d(message.angular_velocity_radps),
                        Eigen::Vector3d(message.acceleration_mps2)};
  if (!reading.angular_velocity_radps.allFinite()) return Fault{"the angular velocity is not finite"};
  if (!reading.acceleration_mps2.allFinite()) return Fault{"the acceleration is not finite"};
  if (message.sequence < 0) return Fault{"the sequence is negative"};
  return reading;
}

}  // namespace arpent::imu
