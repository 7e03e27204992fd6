// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target: any bytes are a log that can be read to its end.
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "common/log/event_log.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("arpent_fuzz_" + std::to_string(getpid()) + ".lcmlog");
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  arpent::LogReader reader(file);
  std::size_t total = 0;
  while (const auto event = reader.next()) total += event->data.size() + event->channel.size();
  if (total > size) std::abort();
  reader.seek(arpent::from_utime(1000));
  (void)reader.next();
  return 0;
}
