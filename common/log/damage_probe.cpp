// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/log/damage_probe.h"

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "common/crc32c.h"
#include "common/log/event_log.h"

namespace arpent {
namespace {

/// An event as its number, channel and content.
using Identity = std::tuple<std::string, std::uint32_t, std::size_t>;

struct Contents {
  std::multiset<Identity> events;
  std::vector<std::pair<std::uint64_t, Identity>> ends;  ///< with the file position behind each
};

Contents read(const std::filesystem::path& file) {
  Contents contents;
  LogReader reader(file);
  while (const auto event = reader.next()) {
    const Identity identity{event->channel, crc32c_of(event->data), event->data.size()};
    contents.events.insert(identity);
    contents.ends.emplace_back(reader.position_bytes(), identity);
  }
  return contents;
}

std::int64_t count_lost(const Contents& whole, const Contents& damaged, std::uint64_t up_to) {
  std::multiset<Identity> left = damaged.events;
  std::int64_t lost = 0;
  for (const auto& [end, identity] : whole.ends) {
    const auto found = left.find(identity);
    if (found != left.end()) {
      left.erase(found);
    } else if (end <= up_to) {
      ++lost;
    }
  }
  return lost;
}

}  // namespace

DamageProbe probe_damage(const std::filesystem::path& log, const std::filesystem::path& scratch_file) {
  std::stringstream stream;
  stream << std::ifstream(log, std::ios::binary).rdbuf();
  const std::string bytes = stream.str();
  const Contents whole = read(log);
  DamageProbe probe;
  const auto judge = [&](const std::string& damaged) {
    std::ofstream(scratch_file, std::ios::binary) << damaged;
    ++probe.cases;
    probe.most_lost = std::max(probe.most_lost, count_lost(whole, read(scratch_file), damaged.size()));
  };
  for (std::size_t size = 0; size < bytes.size(); ++size) judge(bytes.substr(0, size));
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const int mask : {0xFF, 0x01}) {
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ mask);
      judge(damaged);
    }
  }
  return probe;
}

}  // namespace arpent
