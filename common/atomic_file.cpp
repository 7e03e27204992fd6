// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "common/error.h"

namespace arpent {
namespace {

/// A temporary file beside its place that is removed unless it was renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::filesystem::path target) : target_(std::move(target)) {
    path_ = target_.string() + ".XXXXXX";
    fd_ = mkstemp(path_.data());
    if (fd_ < 0) fail();
    fchmod_as_created();
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (fd_ >= 0) close(fd_);
    if (!renamed_ && !path_.empty()) unlink(path_.c_str());
  }

  void write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::write(fd_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail();
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
  }

  void commit() {
    if (fsync(fd_) != 0) fail();
    const int fd = fd_;
    fd_ = -1;
    if (close(fd) != 0) fail();
    if (rename(path_.c_str(), target_.c_str()) != 0) fail();
    renamed_ = true;
    sync_folder();
  }

 private:
  /// mkstemp makes files private; ours get the permissions that any new file would.
  void fchmod_as_created() const {
    const mode_t mask = umask(0);
    umask(mask);
    fchmod(fd_, 0666 & ~mask);
  }

  void sync_folder() const {
    const std::filesystem::path folder = target_.has_parent_path() ? target_.parent_path() : ".";
    const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return;
    fsync(fd);
    close(fd);
  }

  [[noreturn]] void fail() const { throw InputError("cannot write " + target_.string() + ": " + std::strerror(errno)); }

  std::filesystem::path target_;
  std::string path_;
  int fd_ = -1;
  bool renamed_ = false;
};

}  // namespace

void atomic_write(const std::filesystem::path& path, const std::function<void(const WriteBytes&)>& produce) {
  TemporaryFile file(path);
  produce([&file](std::span<const std::byte> bytes) { file.write(bytes); });
  file.commit();
}

void atomic_write(const std::filesystem::path& path, std::string_view content) {
  atomic_write(path, [content](const WriteBytes& write) { write(std::as_bytes(std::span(content))); });
}

}  // namespace arpent
