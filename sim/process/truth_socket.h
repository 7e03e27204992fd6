// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How simulators in processes of their own tell each other where their robots are: local datagram sockets NAME.sock in
// one folder, which network namespaces do not separate. Nothing but TRUTH_POSE goes over them, and no process of a
// robot knows of them: what a robot learns of its teammates it sees, or hears over the radio. In lockstep the bus does
// this.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace arpent {

class TruthSocket {
 public:
  /// Throws InputError if the socket `name`.sock cannot be made in `folder`.
  TruthSocket(const std::filesystem::path& folder, const std::string& name, const std::vector<std::string>& teammates);
  ~TruthSocket();
  TruthSocket(const TruthSocket&) = delete;
  TruthSocket& operator=(const TruthSocket&) = delete;

  /// To every teammate; one that is not there, or does not read, misses it. Never waits.
  void send(std::span<const std::uint8_t> message) const;
  /// What has come since, each with its sender; from teammates alone.
  void receive(const std::function<void(const std::string& teammate, std::span<const std::uint8_t>)>& take) const;

 private:
  std::filesystem::path folder_;
  std::string name_;
  std::vector<std::string> teammates_;
  int fd_ = -1;
};

}  // namespace arpent
