// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target: any text is a configuration or a list of faults.
#include <cstdint>
#include <string>

#include "common/config/rig.h"
#include "common/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const auto rig = arpent::config::load_text<arpent::RigConfig>("fuzz", text);
    (void)arpent::to_calibration(rig, "fuzz");
  } catch (const arpent::InputError&) {
  }
  return 0;
}
