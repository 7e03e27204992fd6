// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent launch FILE`: starts the processes that a launch file names, watches and restarts them, and stops them on
// Ctrl-C.
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "common/error.h"
#include "tools/launch/launcher.h"
#include "tools/launch/systemd.h"

namespace {

using namespace arpent;
using namespace arpent::tools;
namespace fs = std::filesystem;

volatile std::sig_atomic_t g_stop = 0;
void on_signal(int /*signal*/) {
  g_stop = 1;
}

struct LaunchFile {
  std::string log = "launch.log";
  std::vector<ProcessSpec> processes;
};

/// processes: a list of {name, config, set: [key=value]}; lcm_url; log. Every fault is listed.
LaunchFile read(const fs::path& file, const fs::path& bin) {
  std::vector<std::string> faults;
  LaunchFile launch;
  try {
    const YAML::Node root = YAML::LoadFile(file.string());
    std::string url;
    for (const auto& item : root) {
      const auto key = item.first.as<std::string>();
      if (key == "lcm_url")
        url = item.second.as<std::string>();
      else if (key == "log")
        launch.log = item.second.as<std::string>();
      else if (key != "processes")
        faults.push_back(fmt::format("{}:{}: unknown key {}", file.string(), item.first.Mark().line + 1, key));
    }
    for (const auto& node : root["processes"]) {
      const auto name = node["name"].as<std::string>("");
      ProcessSpec spec{name, {(bin / name).string()}, true};
      if (name.empty())
        faults.push_back(fmt::format("{}:{}: a process without a name", file.string(), node.Mark().line + 1));
      if (node["config"])
        spec.command.insert(spec.command.end(),
                            {"--config", (file.parent_path() / node["config"].as<std::string>()).string()});
      if (!url.empty()) spec.command.insert(spec.command.end(), {"--lcm-url", url});
      for (const auto& setting : node["set"])
        spec.command.insert(spec.command.end(), {"--set", setting.as<std::string>()});
      launch.processes.push_back(spec);
    }
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}:{}: {}", file.string(), error.mark.line + 1, error.msg));
  }
  if (launch.processes.empty()) faults.push_back(file.string() + ": names no processes");
  if (!faults.empty()) throw InputError(fmt::format("{}", fmt::join(faults, "\n")));
  return launch;
}

int print_units(const LaunchFile& launch) {
  for (const UnitFile& unit : to_units(launch.processes, fs::current_path())) {
    fmt::print("# {}\n{}\n", unit.name, unit.text);
  }
  return 0;
}

int run(const LaunchFile& launch) {
  Launcher launcher(launch.log);
  for (const ProcessSpec& spec : launch.processes) launcher.start(spec);
  std::printf("%zu processes run; their output is in %s; Ctrl-C stops them\n", launch.processes.size(),
              launch.log.c_str());
  while (g_stop == 0) {
    launcher.poll(100);
    for (const auto& child : launcher.children()) {
      if (!child.gave_up) continue;
      std::fprintf(stderr, "launch: %s ends again and again (code %d): see %s\n", child.spec.name.c_str(),
                   child.exit_code, launch.log.c_str());
      launcher.stop_all(5000);
      return 1;
    }
  }
  return launcher.stop_all(20000) == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Starts, watches, restarts and stops the processes of a robot (docs/config.md describes the file)."};
  app.name("arpent launch");
  std::string file;
  bool units = false;
  app.add_option("FILE", file, "launch file (YAML)")->required();
  app.add_flag("--systemd", units, "start nothing: print the processes as units of systemd");
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  try {
    app.parse(argc, argv);
    const LaunchFile launch = read(fs::absolute(file), fs::canonical("/proc/self/exe").parent_path());
    return units ? print_units(launch) : run(launch);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "launch: %s\n", error.what());
    return 2;
  }
}
