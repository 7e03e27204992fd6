// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/compact.h"

#include <arpent/depth_t.hpp>
#include <arpent/disparity_t.hpp>
#include <arpent/stereo_images_t.hpp>
#include <initializer_list>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/image_codec.h"

namespace arpent::tools {
namespace {

/// Compresses the images that `list` names in a message; false if one cannot be decoded.
template <class Message>
Bytes compact(BytesView bytes, std::initializer_list<image_t Message::*> list) {
  Message message;
  std::string fault;
  const Bytes unchanged(bytes.begin(), bytes.end());
  if (!decode_guarded(bytes, message, fault)) return unchanged;
  for (image_t Message::*image : list) {
    const auto decoded = decode_image(message.*image);
    if (!decoded) return unchanged;
    message.*image = encode_image(*decoded, Compression::kZstd);
  }
  return encode(message);
}

}  // namespace

Bytes compact_for_log(const std::string& channel, BytesView bytes) {
  if (channel == channels::kStereoImages) {
    return compact<stereo_images_t>(bytes, {&stereo_images_t::left, &stereo_images_t::right});
  }
  if (channel == channels::kDepth) return compact<depth_t>(bytes, {&depth_t::depth, &depth_t::sigma});
  if (channel == channels::kDisparity || channel == channels::kDisparityFilled) {
    return compact<disparity_t>(bytes, {&disparity_t::disparity});
  }
  return Bytes(bytes.begin(), bytes.end());
}

}  // namespace arpent::tools
