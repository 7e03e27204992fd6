// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A loop in several threads that end with the call.
#pragma once

#include <algorithm>
#include <thread>
#include <vector>

namespace arpent {

/// Calls work(begin, end) for `threads` contiguous parts of [0, count), the last one in the calling thread, and returns
/// when all are done. `work` must not throw and its parts must not depend on each other.
template <class Work>
void parallel_for(int threads, int count, const Work& work) {
  const int parts = std::clamp(threads, 1, std::max(count, 1));
  std::vector<std::jthread> helpers;
  helpers.reserve(static_cast<std::size_t>(parts - 1));
  const auto bound = [&](int part) { return static_cast<int>(static_cast<long long>(count) * part / parts); };
  for (int part = 0; part + 1 < parts; ++part) {
    helpers.emplace_back([&work, begin = bound(part), end = bound(part + 1)] { work(begin, end); });
  }
  work(bound(parts - 1), count);
}

}  // namespace arpent
