// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Room on the disk that a mission's log cannot take: the log grows until the disk is full, and then map, certificate
// and report must still be written.
#pragma once

#include <cstdint>
#include <filesystem>

namespace arpent::tools {

class DiskReserve {
 public:
  static constexpr std::uint64_t kBytes = 32U << 20;

  /// Occupies kBytes in the folder, which it makes if need be. Throws InputError if they are not there: too little for
  /// any mission.
  explicit DiskReserve(const std::filesystem::path& folder);
  ~DiskReserve() { give_back(); }
  DiskReserve(const DiskReserve&) = delete;
  DiskReserve& operator=(const DiskReserve&) = delete;

  /// For what is to be written now. False if there was nothing to give back any more.
  bool give_back() noexcept;
  /// The log was refused: says so, once, and gives the room back.
  void log_was_refused();

 private:
  std::filesystem::path file_;
};

}  // namespace arpent::tools
