// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "link/dds_settings.h"

#include <fmt/format.h>

#include "common/error.h"
#include "common/split.h"

namespace arpent::link {
namespace {

namespace fs = std::filesystem;

std::string peer_list(const std::string& peers) {
  std::string xml;
  for (const std::string& address : split(peers, ',')) {
    if (!address.empty()) xml += fmt::format("<Peer address=\"{}\"/>", address);
  }
  return "<Peers>" + xml + "</Peers>";
}

}  // namespace

std::string cyclone_config(const LinkParams& params) {
  const bool multicast = params.peers.empty();
  const bool secure = params.security == "on";
  // A sealed packet is 100 to 150 bytes longer; one that IP has to cut is lost twice as often.
  const int message_bytes = secure ? 1300 : 1400;
  const int fragment_bytes = secure ? 1100 : 1300;
  return fmt::format(
      "<CycloneDDS><Domain Id=\"any\">"
      "<General><Interfaces><NetworkInterface name=\"{}\"/></Interfaces><AllowMulticast>{}</AllowMulticast>"
      "<MaxMessageSize>{}B</MaxMessageSize><FragmentSize>{}B</FragmentSize></General>"
      "<Discovery><LeaseDuration>60s</LeaseDuration><SPDPInterval>1s</SPDPInterval>"
      "<ParticipantIndex>{}</ParticipantIndex><MaxAutoParticipantIndex>9</MaxAutoParticipantIndex>{}</Discovery>"
      "<Internal><Watermarks><WhcLow>1MB</WhcLow><WhcHighInit>8MB</WhcHighInit><WhcHigh>32MB</WhcHigh></Watermarks>"
      // Several receive threads are woken by packets at their end: without the interface they would wait for ever.
      "<MultipleReceiveThreads>false</MultipleReceiveThreads>"
      "<NackDelay>20ms</NackDelay><AutoReschedNackDelay>300ms</AutoReschedNackDelay>"
      "<HeartbeatInterval min=\"20ms\" minsched=\"20ms\" max=\"300ms\">100ms</HeartbeatInterval></Internal>"
      "</Domain></CycloneDDS>",
      params.interface, multicast ? "true" : "false", message_bytes, fragment_bytes, multicast ? "none" : "auto",
      multicast ? "" : peer_list(params.peers));
}

std::vector<std::pair<std::string, std::string>> security_properties(const LinkParams& params) {
  if (params.security != "on") return {};
  std::vector<std::pair<std::string, std::string>> properties;
  for (const auto& [name, file] : kKeyFiles) {
    const fs::path path = params.keys / file;
    if (params.keys.empty() || !fs::exists(path)) {
      throw InputError(fmt::format(
          "link.keys = {}: {} is not there; make keys with `./arpent team keys --out DIR --robots R1 R2 centre`",
          params.keys.string(), file));
    }
    properties.emplace_back(name, "file:" + fs::absolute(path).string());
  }
  const auto library = [&](const std::string& part, const std::string& file, const std::string& function) {
    const std::string prefix = "dds.sec." + part + ".library.";
    properties.emplace_back(prefix + "path", std::string(ARPENT_DDS_SECURITY_DIR "/libdds_security_") + file + ".so");
    properties.emplace_back(prefix + "init", "init_" + function);
    properties.emplace_back(prefix + "finalize", "finalize_" + function);
  };
  library("auth", "auth", "authentication");
  library("crypto", "crypto", "crypto");
  library("access", "ac", "access_control");
  return properties;
}

}  // namespace arpent::link
