// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/log/event_log.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "common/error.h"

namespace arpent {
namespace {

constexpr std::uint32_t kSync = 0xEDA1DA01;
constexpr std::uint64_t kHeaderBytes = 28;
constexpr std::uint32_t kMaxChannelBytes = 63;  // LCM's limit
constexpr std::uint32_t kMaxDataBytes = 256U << 20;
constexpr std::size_t kBufferBytes = 1 << 20;
/// A larger jump of the event number is damage of the number itself.
constexpr std::int64_t kMaxGap = 1'000'000;

template <class T>
T read_big_endian(const std::uint8_t* bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = value << 8 | bytes[i];
  return static_cast<T>(value);
}

template <class T>
void append_big_endian(std::vector<std::uint8_t>& buffer, T value) {
  for (int shift = 8 * static_cast<int>(sizeof(T)) - 8; shift >= 0; shift -= 8) {
    buffer.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> shift));
  }
}

bool is_channel(const std::uint8_t* bytes, std::size_t size) {
  return std::all_of(bytes, bytes + size, [](std::uint8_t c) { return c > 0x20 && c < 0x7F; });
}

}  // namespace

LogReader::LogReader(const std::filesystem::path& file) {
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (fd < 0 || fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
    if (fd >= 0) close(fd);
    throw InputError("cannot read the log " + file.string());
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
  if (size_ > 0) {
    void* mapped = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, fd, 0);
    close(fd);
    if (mapped == MAP_FAILED) throw InputError("cannot read the log " + file.string());
    bytes_ = static_cast<const std::uint8_t*>(mapped);
  } else {
    close(fd);
  }
}

LogReader::~LogReader() {
  if (bytes_ != nullptr) munmap(const_cast<std::uint8_t*>(bytes_), size_);
}

std::optional<LogEvent> LogReader::event_at(std::uint64_t at, std::uint64_t& end) const {
  if (size_ - at < kHeaderBytes || read_big_endian<std::uint32_t>(bytes_ + at) != kSync) return std::nullopt;
  const auto channel_bytes = read_big_endian<std::uint32_t>(bytes_ + at + 20);
  const auto data_bytes = read_big_endian<std::uint32_t>(bytes_ + at + 24);
  if (channel_bytes == 0 || channel_bytes > kMaxChannelBytes || data_bytes > kMaxDataBytes) return std::nullopt;
  end = at + kHeaderBytes + channel_bytes + data_bytes;
  if (end > size_) return std::nullopt;
  const std::uint8_t* channel = bytes_ + at + kHeaderBytes;
  if (!is_channel(channel, channel_bytes)) return std::nullopt;
  return LogEvent{read_big_endian<std::int64_t>(bytes_ + at + 4),
                  from_utime(read_big_endian<std::int64_t>(bytes_ + at + 12)),
                  std::string(channel, channel + channel_bytes),
                  {channel + channel_bytes, data_bytes}};
}

bool LogReader::swallows_another(const LogEvent& event, std::uint64_t at, std::uint64_t end) const {
  static constexpr std::uint8_t kSyncBytes[] = {0xED, 0xA1, 0xDA, 0x01};
  for (std::uint64_t from = at + 4; from + 4 <= end;) {
    const void* found = memmem(bytes_ + from, end - from, kSyncBytes, sizeof kSyncBytes);
    if (found == nullptr) return false;
    const auto inner = static_cast<std::uint64_t>(static_cast<const std::uint8_t*>(found) - bytes_);
    std::uint64_t inner_end = 0;
    const auto other = event_at(inner, inner_end);
    if (other && other->number > event.number && other->number <= event.number + 2) return true;
    from = inner + 1;
  }
  return false;
}

std::optional<LogEvent> LogReader::next() {
  const std::uint64_t start = at_;
  for (std::uint64_t at = at_; at < size_; ++at) {
    std::uint64_t end = 0;
    auto event = event_at(at, end);
    // A damaged length would swallow the events behind it.
    if (!event || swallows_another(*event, at, end)) continue;
    if (at > start) {
      ++damage_.places;
      damage_.bytes += static_cast<std::int64_t>(at - start);
    }
    if (last_number_ >= 0 && event->number > last_number_) {
      const std::int64_t missing = event->number - last_number_ - 1;
      if (missing < kMaxGap) damage_.missing += missing;
    }
    last_number_ = event->number;
    at_ = end;
    return event;
  }
  if (start < size_) {
    ++damage_.places;
    damage_.bytes += static_cast<std::int64_t>(size_ - start);
  }
  at_ = size_;
  return std::nullopt;
}

void LogReader::rewind() {
  at_ = 0;
  last_number_ = -1;
  damage_ = {};
}

void LogReader::seek(Time time) {
  rewind();
  for (std::uint64_t at = at_; const auto event = next(); at = at_) {
    if (event->time < time) continue;
    at_ = at;
    last_number_ = std::max<std::int64_t>(event->number, 0) - 1;
    return;
  }
}

LogWriter::LogWriter(const std::filesystem::path& file) : file_(file) {
  fd_ = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd_ < 0) throw InputError("cannot write the log " + file.string() + ": " + std::strerror(errno));
}

LogWriter::~LogWriter() {
  if (fd_ < 0) return;
  drain();
  ::close(fd_);
}

bool LogWriter::write(Time time, const std::string& channel, std::span<const std::uint8_t> data) {
  ARPENT_ASSERT(!channel.empty() && channel.size() <= kMaxChannelBytes);
  if (!fault_.empty()) return false;
  append_big_endian(buffer_, kSync);
  append_big_endian(buffer_, next_number_++);
  append_big_endian(buffer_, to_utime(time));
  append_big_endian(buffer_, static_cast<std::uint32_t>(channel.size()));
  append_big_endian(buffer_, static_cast<std::uint32_t>(data.size()));
  buffer_.insert(buffer_.end(), channel.begin(), channel.end());
  buffer_.insert(buffer_.end(), data.begin(), data.end());
  length_ = position_ + buffer_.size();
  ends_.push_back(length_);
  return buffer_.size() < kBufferBytes || drain();
}

/// Hands the buffer to the disk. After a refusal the file is cut behind its last whole event.
bool LogWriter::drain() {
  std::size_t done = 0;
  while (fault_.empty() && done < buffer_.size()) {
    const ssize_t count = ::write(fd_, buffer_.data() + done, buffer_.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      fault_ = std::strerror(errno);
    } else {
      done += static_cast<std::size_t>(count);
    }
  }
  position_ += done;
  buffer_.clear();
  if (fault_.empty()) return true;
  const auto whole = std::upper_bound(ends_.begin(), ends_.end(), position_);
  const std::uint64_t keep = whole == ends_.begin() ? position_ - done : *(whole - 1);
  if (ftruncate(fd_, static_cast<off_t>(keep)) == 0) position_ = keep;
  return false;
}

bool LogWriter::flush() {
  const bool drained = drain();
  if (fd_ >= 0 && fsync(fd_) == 0) {
    const auto whole = std::upper_bound(ends_.begin(), ends_.end(), position_);
    on_disk_ += whole - ends_.begin();
    ends_.erase(ends_.begin(), whole);
  } else if (fault_.empty()) {
    fault_ = std::strerror(errno);
  }
  return drained && fault_.empty();
}

void LogWriter::close() {
  flush();
  if (fd_ >= 0 && ::close(fd_) != 0 && fault_.empty()) fault_ = std::strerror(errno);
  fd_ = -1;
  if (!fault_.empty()) {
    throw InputError("the log " + file_.string() + " is not complete: " + fault_ + "; " + std::to_string(on_disk_) +
                     " events are on disk");
  }
}

}  // namespace arpent
