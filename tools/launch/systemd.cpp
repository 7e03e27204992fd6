// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/launch/systemd.h"

#include <map>

namespace arpent::tools {
namespace {

constexpr char kTarget[] = "arpent.target";

/// An argument as systemd.service(5) wants it: in quotes, without specifiers and variables.
std::string quoted(const std::string& argument) {
  std::string text = "\"";
  for (const char c : argument) {
    if (c == '"' || c == '\\') text += '\\';
    if (c == '%' || c == '$') text += c;
    text += c;
  }
  return text + '"';
}

std::string service(const ProcessSpec& process, const std::string& folder) {
  std::string start;
  for (const std::string& word : process.command) start += (start.empty() ? "" : " ") + quoted(word);
  return "[Unit]\nDescription=arpent " + process.name + "\nPartOf=" + kTarget +
         "\nStartLimitIntervalSec=10\nStartLimitBurst=4\n\n[Service]\nType=exec\nExecStart=" + start +
         "\nWorkingDirectory=" + folder + "\nRestart=" + (process.restart ? "always" : "no") +
         "\nRestartSec=100ms\nTimeoutStopSec=20\n"
         // For base_driver_process, which runs under SCHED_FIFO with locked memory.
         "LimitRTPRIO=90\nLimitMEMLOCK=infinity\n\n[Install]\nWantedBy=" +
         kTarget + "\n";
}

}  // namespace

std::vector<UnitFile> to_units(const std::vector<ProcessSpec>& processes, const std::filesystem::path& folder) {
  std::vector<UnitFile> units;
  std::map<std::string, int> seen;
  std::string wanted;
  for (const ProcessSpec& process : processes) {
    const int number = ++seen[process.name];
    const std::string name = "arpent-" + process.name + (number > 1 ? "-" + std::to_string(number) : "") + ".service";
    units.push_back({name, service(process, folder.string())});
    wanted += " " + name;
  }
  units.push_back({kTarget, "[Unit]\nDescription=arpent robot\nWants=" + wanted.substr(wanted.empty() ? 0 : 1) +
                                "\nAfter=network.target\n\n[Install]\nWantedBy=multi-user.target\n"});
  return units;
}

}  // namespace arpent::tools
