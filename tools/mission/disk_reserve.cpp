// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/disk_reserve.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "common/error.h"

namespace arpent::tools {

DiskReserve::DiskReserve(const std::filesystem::path& folder) : file_(folder / ".reserve") {
  std::filesystem::create_directories(folder);
  const int fd = open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const int fault = fd < 0 ? errno : posix_fallocate(fd, 0, static_cast<off_t>(kBytes));
  if (fd >= 0) close(fd);
  if (fault == 0) return;
  give_back();
  throw InputError(fmt::format("cannot keep {} MB for the map in {}: {}; make room or choose another folder with --out",
                               kBytes >> 20, folder.string(), std::strerror(fault)));
}

bool DiskReserve::give_back() noexcept {
  std::error_code ignored;
  return std::filesystem::remove(file_, ignored);
}

void DiskReserve::log_was_refused() {
  if (!give_back()) return;
  std::fprintf(stderr, "\nmission: the disk takes no more: the log ends here, the mission goes on and keeps its map\n");
}

}  // namespace arpent::tools
