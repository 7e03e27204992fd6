// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/process/centre_journal.h"

#include "common/error.h"

namespace arpent {
namespace {

constexpr Duration kKeepEvery = std::chrono::milliseconds(500);
constexpr Duration kSometimes = std::chrono::seconds(1);

}  // namespace

CentreJournal::CentreJournal(const std::filesystem::path& file, const Reader& reader) {
  std::filesystem::path fresh = file;
  fresh += ".new";
  log_ = std::make_unique<LogWriter>(fresh);
  if (std::filesystem::exists(file)) {
    LogReader old(file);
    while (const auto event = old.next()) {
      reader(event->time, event->channel, event->data);
      log_->write(event->time, event->channel, event->data);
    }
  }
  if (!log_->flush()) throw InputError("cannot write the journal " + file.string() + ": the disk refused");
  std::filesystem::rename(fresh, file);  // until here the old one is untouched
}

void CentreJournal::note(Time now, const std::string& channel, BytesView bytes) {
  if (log_) log_->write(now, channel, bytes);
}

void CentreJournal::note_sometimes(Time now, const std::string& channel, const std::string& sender, BytesView bytes) {
  const auto [noted, first] = noted_.try_emplace(sender, now);
  if (!first && now - noted->second < kSometimes) return;
  noted->second = now;
  note(now, channel, bytes);
}

bool CentreJournal::keep(Time now) {
  if (log_ == nullptr) return false;
  if (now - kept_ < kKeepEvery) return true;
  kept_ = now;
  if (log_->flush()) return true;
  log_.reset();
  return false;
}

}  // namespace arpent
