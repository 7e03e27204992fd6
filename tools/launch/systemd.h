// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The processes of a launch file as units of systemd, for a robot that starts by itself: the same rules as the
// launcher's (what ends is started again, what ends again and again is given up), kept by the system.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/launch/launcher.h"

namespace arpent::tools {

struct UnitFile {
  std::string name;  ///< of the file
  std::string text;
};

/// One arpent-NAME.service for each process, and arpent.target, which starts and stops them together. Processes that
/// run twice are told apart by a number. `folder`: where relative paths of their arguments begin.
[[nodiscard]] std::vector<UnitFile> to_units(const std::vector<ProcessSpec>& processes,
                                             const std::filesystem::path& folder);

}  // namespace arpent::tools
