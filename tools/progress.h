// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A progress bar on a terminal, nothing elsewhere.
#pragma once

#include <unistd.h>

#include <cstdio>
#include <string>

namespace arpent::tools {

inline void show_progress(const std::string& what, std::size_t done, std::size_t total) {
  static const bool terminal = isatty(STDERR_FILENO) != 0;
  if (!terminal || total == 0) return;
  constexpr std::size_t kWidth = 30;
  const std::size_t filled = kWidth * done / total;
  std::fprintf(stderr, "\r%-12s [%s%s] %zu/%zu%s", what.c_str(), std::string(filled, '#').c_str(),
               std::string(kWidth - filled, ' ').c_str(), done, total, done == total ? "\n" : "");
}

}  // namespace arpent::tools
