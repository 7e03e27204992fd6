// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent team keys`: the keys with which a team's stations know each other on the radio.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "common/error.h"
#include "tools/team/keys.h"

int main(int argc, char** argv) {
  using namespace arpent;
  CLI::App app{"What a team needs beside its robots.", "arpent team"};
  app.require_subcommand(1);
  tools::KeyOptions options;
  CLI::App* keys = app.add_subcommand("keys", "keys and certificates of the radio link (docs/teams.md)");
  keys->add_option("--out", options.out, "folder: OUT/STATION goes to that station, OUT/authority stays here")
      ->required();
  keys->add_option("--robots", options.stations, "names of the stations, robots and centre; again later for more")
      ->required();
  keys->add_option("--domain", options.domain, "DDS domain that they are good for (link.domain)")
      ->check(CLI::Range(0, 230))
      ->capture_default_str();
  keys->add_option("--valid-days", options.valid_days, "from today")
      ->check(CLI::Range(1, 36500))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    tools::make_keys(options);
    for (const std::string& station : options.stations) std::printf("%s\n", (options.out / station).c_str());
    std::printf("Copy each folder to its station alone; keep %s here.\n", (options.out / "authority").c_str());
    return 0;
  } catch (const InputError& error) {
    std::fprintf(stderr, "team: %s\n", error.what());
    return 2;
  }
}
