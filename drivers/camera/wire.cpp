// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/wire.h"

#include "common/image_codec.h"

namespace arpent::camera {

stereo_images_t to_wire(const FramePair& pair) {
  stereo_images_t message{};
  message.utime = to_utime(pair.stamp);
  message.sequence = pair.sequence;
  message.exposure_us = pair.left.exposure_us;
  message.gain_db = static_cast<float>(pair.left.gain_db);
  message.left = encode_image(pair.left.image);
  message.right = encode_image(pair.right.image);
  return message;
}

}  // namespace arpent::camera
