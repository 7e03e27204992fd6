// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target: what the guard lets through must be safe for the generated decoders and for wire. The first byte chooses
// the type.
#include <arpent/depth_t.hpp>
#include <arpent/disparity_t.hpp>
#include <arpent/health_t.hpp>
#include <arpent/map_status_t.hpp>
#include <arpent/odometry_t.hpp>
#include <arpent/stereo_images_t.hpp>
#include <cstdint>
#include <vector>

#include "common/bus/typed.h"
#include "common/wire_schema.h"
#include "perception/stereo/wire.h"

namespace {

template <class Message>
bool decode(const std::vector<std::uint8_t>& bytes, Message& message) {
  std::string fault;
  return arpent::decode_guarded(bytes, message, fault);
}

template <class Message>
void feed(std::vector<std::uint8_t> bytes) {
  // Give every input the right fingerprint: the fuzzer need not guess eight bytes.
  const std::uint64_t fingerprint = arpent::wire_schema().fingerprint(Message::getTypeName());
  if (bytes.size() < 8) bytes.resize(8);
  for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(fingerprint >> (56 - 8 * i));
  Message message;
  if (!decode(bytes, message)) return;
  if constexpr (requires { arpent::stereo::from_wire(message); }) (void)arpent::stereo::from_wire(message);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::vector<std::uint8_t> bytes(data + 1, data + size);
  switch (data[0] % 6) {
    case 0:
      feed<arpent::stereo_images_t>(bytes);
      break;
    case 1:
      feed<arpent::depth_t>(bytes);
      break;
    case 2:
      feed<arpent::disparity_t>(bytes);
      break;
    case 3:
      feed<arpent::odometry_t>(bytes);
      break;
    case 4:
      feed<arpent::map_status_t>(bytes);
      break;
    default:
      feed<arpent::health_t>(bytes);
      break;
  }
  return 0;
}
