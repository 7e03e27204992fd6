// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The keys of a team's radio link (DDS Security): one authority, and for each station a folder with what it needs, to
// be copied to that station alone. All cryptography is the openssl command's.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace arpent::tools {

struct KeyOptions {
  std::filesystem::path out;
  std::vector<std::string> stations;
  int domain = 42;
  int valid_days = 825;
};

/// Makes OUT/authority (its key never leaves the machine) unless it is there, and OUT/STATION for each station. Throws
/// InputError for names that cannot be, a station that has its folder already, or where openssl refuses.
void make_keys(const KeyOptions& options);

}  // namespace arpent::tools
