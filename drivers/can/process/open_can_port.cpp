// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/process/open_can_port.h"

#include <algorithm>
#include <cctype>

#include "common/error.h"
#include "drivers/can/candump.h"
#include "drivers/can/local_hub.h"
#include "drivers/can/process/bus_port.h"
#include "drivers/can/socketcan_port.h"

namespace arpent::can {
namespace {

constexpr std::size_t kLongestInterface = 15;

bool is_interface_name(const std::string& text) {
  return !text.empty() && text.size() <= kLongestInterface && std::isalpha(static_cast<unsigned char>(text[0])) != 0 &&
         std::all_of(text.begin(), text.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-'; });
}

/// What follows `prefix`, if the text begins with it.
std::optional<std::string> after(const std::string& prefix, const std::string& text) {
  if (text.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
  return text.substr(prefix.size());
}

}  // namespace

std::unique_ptr<CanPort> open_can_port(const std::string& spec, const std::string& place, Bus& bus, Clock& clock,
                                       const std::vector<std::uint32_t>& heard_ids) {
  const Now now = [&clock] { return clock.now(); };
  if (spec == "bus") return std::make_unique<BusPort>(place, bus, clock);
  if (const auto path = after("socket:", spec)) return std::make_unique<LocalPort>(*path, now);
  if (const auto file = after("candump:", spec)) return std::make_unique<CandumpPort>(*file, now);
  if (is_interface_name(spec)) return std::make_unique<SocketCanPort>(spec, heard_ids, now);
  throw InputError("CAN port '" + spec + "': must be an interface (can0), socket:PATH, candump:FILE or bus");
}

}  // namespace arpent::can
