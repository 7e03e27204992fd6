// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent log`: what is in a log, whether it is whole, and what can be saved of a damaged one.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>

#include "common/error.h"
#include "common/log/event_log.h"
#include "common/wire_schema.h"

namespace {

using namespace arpent;

struct Channel {
  std::int64_t events = 0, bytes = 0, undecodable = 0;
  Time first, last;
  Duration largest_gap{0};
  std::string type;
};

void add(Channel& channel, const LogEvent& event) {
  if (channel.events == 0) channel.first = channel.last = event.time;
  ++channel.events;
  channel.bytes += static_cast<std::int64_t>(event.data.size());
  channel.largest_gap = std::max(channel.largest_gap, event.time - channel.last);
  channel.last = event.time;
  const std::string type = wire_schema().type_of(event.data);
  if (type.empty() || wire_schema().check(type, event.data))
    ++channel.undecodable;
  else
    channel.type = type;
}

int report_damage(const LogDamage& damage) {
  if (damage.places == 0 && damage.missing == 0) return 0;
  fmt::print("damage: {} places, {} bytes passed over, {} events missing\n", damage.places, damage.bytes,
             damage.missing);
  return 1;
}

int info(const std::string& file) {
  LogReader reader(file);
  std::map<std::string, Channel> channels;
  std::int64_t backwards = 0;
  std::optional<Time> last;
  while (const auto event = reader.next()) {
    add(channels[event->channel], *event);
    backwards += last && event->time < *last ? 1 : 0;
    last = event->time;
  }
  fmt::print("{:24} {:18} {:>8} {:>10} {:>8} {:>12}\n", "channel", "type", "events", "kB", "Hz", "largest gap");
  for (const auto& [name, c] : channels) {
    const double seconds = to_seconds(c.last - c.first);
    fmt::print("{:24} {:18} {:>8} {:>10} {:>8.2f} {:>10.3f} s\n", name, c.type.empty() ? "(not ours)" : c.type,
               c.events, c.bytes / 1000, seconds > 0 ? static_cast<double>(c.events - 1) / seconds : 0.0,
               to_seconds(c.largest_gap));
    if (!c.type.empty() && c.undecodable > 0) fmt::print("{:24} {} events cannot be decoded\n", "", c.undecodable);
  }
  if (backwards > 0) fmt::print("event times go back {} times\n", backwards);
  return report_damage(reader.damage());
}

int repair(const std::string& file, const std::string& out) {
  LogReader reader(file);
  LogWriter writer(out);
  while (const auto event = reader.next()) writer.write(event->time, event->channel, event->data);
  writer.close();
  fmt::print("{}: {} intact events\n", out, writer.events_on_disk());
  report_damage(reader.damage());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Looks into LCM logs."};
  app.name("arpent log");
  std::string file, out;
  auto* info_command = app.add_subcommand("info", "channels, types, rates, gaps, damage (exit code 1 if damaged)");
  auto* repair_command = app.add_subcommand("repair", "writes the intact events to a new log");
  for (auto* command : {info_command, repair_command}) command->add_option("LOG", file, "the log")->required();
  repair_command->add_option("--out", out, "the new log")->required();
  app.require_subcommand(1);
  try {
    app.parse(argc, argv);
    return *info_command ? info(file) : repair(file, out);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "log: %s\n", error.what());
    return 2;
  }
}
