// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/candump.h"

#include <cerrno>
#include <cstring>

#include "common/error.h"

namespace arpent::can {
namespace {

/// Frames that candump writes and that we have no type for: remote (#R), FD (##), error (identifier 2…, eight digits).
bool is_other_kind(const std::string& line) {
  const std::size_t mark = line.find('#');
  if (mark == std::string::npos || mark < 9) return false;
  return line.compare(mark, 2, "#R") == 0 || line.compare(mark, 2, "##") == 0 || line.compare(mark - 9, 2, " 2") == 0;
}

}  // namespace

std::vector<LoggedFrame> read_candump(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError("CAN log " + file.string() + " cannot be read: " + std::strerror(errno));
  std::vector<LoggedFrame> frames;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.empty() || is_other_kind(line)) continue;
    auto frame = from_candump_line(line);
    if (!frame) throw InputError(file.string() + ":" + std::to_string(number) + ": not a line of candump -l");
    frames.push_back(std::move(*frame));
  }
  return frames;
}

CandumpPort::CandumpPort(const std::filesystem::path& file, Now now)
    : frames_(read_candump(file)), now_(std::move(now)) {
  if (!frames_.empty()) offset_ = now_() - frames_.front().stamp;
}

std::optional<LoggedFrame> CandumpPort::receive() {
  if (next_ == frames_.size() || frames_[next_].stamp + offset_ > now_()) return std::nullopt;
  LoggedFrame frame = frames_[next_++];
  frame.stamp += offset_;
  return frame;
}

PortState CandumpPort::state() const {
  return next_ == frames_.size() ? PortState::kGone : PortState::kActive;
}

std::string CandumpPort::fault() const {
  return next_ == frames_.size() ? "the log is at its end" : "";
}

RecordingPort::RecordingPort(std::unique_ptr<CanPort> port, const std::filesystem::path& file, Now now)
    : port_(std::move(port)), file_(file), now_(std::move(now)) {
  if (!file_) throw InputError("CAN log " + file.string() + " cannot be written: " + std::strerror(errno));
}

void RecordingPort::write(const LoggedFrame& frame) {
  file_ << to_candump_line(frame) << '\n';
}

bool RecordingPort::send(const CanFrame& frame) {
  const bool taken = port_->send(frame);
  if (taken) write({now_(), "sent", frame});
  return taken;
}

std::optional<LoggedFrame> RecordingPort::receive() {
  auto frame = port_->receive();
  if (frame) write(*frame);
  return frame;
}

}  // namespace arpent::can
