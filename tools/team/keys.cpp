// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/team/keys.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

#include "common/atomic_file.h"
#include "common/config/config.h"
#include "common/error.h"
#include "link/params.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using Days = std::chrono::duration<int, std::ratio<86400>>;

constexpr char kAuthority[] = "authority";

/// Runs openssl in `folder`; what it says on the way is shown only if it fails.
void openssl(const fs::path& folder, const std::vector<std::string>& arguments) {
  const fs::path said = folder / "openssl.log";
  std::vector<std::string> words{"openssl"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, said.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t pid = -1;
  const int refused = posix_spawnp(&pid, "openssl", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (refused != 0) throw InputError("the openssl command is not there: apt-get install openssl");
  int status = 0;
  waitpid(pid, &status, 0);
  if (status != 0) {
    throw InputError(fmt::format("openssl {} failed; {} says why", arguments.front(), said.string()));
  }
  fs::remove(said);
}

void make_private_key(const fs::path& folder) {
  openssl(folder, {"genpkey", "-algorithm", "EC", "-pkeyopt", "ec_paramgen_curve:P-256", "-out", "key.pem"});
  fs::permissions(folder / "key.pem", fs::perms::owner_read | fs::perms::owner_write);
}

void sign(const fs::path& folder, const fs::path& authority, const std::string& name) {
  openssl(folder, {"smime", "-sign", "-in", name + ".xml", "-text", "-out", name + ".p7s", "-signer",
                   (authority / "ca.pem").string(), "-inkey", (authority / "key.pem").string()});
  fs::remove(folder / (name + ".xml"));
}

/// Everything is sealed as a whole, packet by packet, after both ends have proved who they are.
std::string governance_xml(int domain) {
  return fmt::format(R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains><id>{}</id></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>NONE</discovery_protection_kind>
      <liveliness_protection_kind>NONE</liveliness_protection_kind>
      <rtps_protection_kind>ENCRYPT</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>false</enable_discovery_protection>
          <enable_liveliness_protection>false</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>NONE</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
)",
                     domain);
}

std::string permissions_xml(const std::string& station, int domain, int valid_days) {
  const auto now = std::chrono::system_clock::now();
  // A day back: stations' clocks may be a little behind.
  return fmt::format(R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="{0}">
      <subject_name>CN={0},O=arpent</subject_name>
      <validity><not_before>{1:%Y-%m-%dT%H:%M:%S}</not_before><not_after>{2:%Y-%m-%dT%H:%M:%S}</not_after></validity>
      <allow_rule>
        <domains><id>{3}</id></domains>
        <publish><topics><topic>arpent_*</topic></topics></publish>
        <subscribe><topics><topic>arpent_*</topic></topics></subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
)",
                     station, fmt::gmtime(now - Days(1)), fmt::gmtime(now + Days(valid_days)), domain);
}

void make_authority(const fs::path& folder, int valid_days) {
  fs::create_directories(folder);
  fs::permissions(folder, fs::perms::owner_all);
  make_private_key(folder);
  openssl(folder, {"req", "-x509", "-new", "-key", "key.pem", "-sha256", "-days", std::to_string(valid_days), "-subj",
                   "/O=arpent/CN=arpent team authority", "-out", "ca.pem"});
}

void make_station(const KeyOptions& options, const std::string& station) {
  const fs::path authority = fs::absolute(options.out / kAuthority);
  const fs::path folder = options.out / station;
  fs::create_directories(folder);
  fs::permissions(folder, fs::perms::owner_all);
  make_private_key(folder);
  openssl(folder, {"req", "-new", "-key", "key.pem", "-subj", "/O=arpent/CN=" + station, "-out", "request.pem"});
  openssl(folder, {"x509", "-req", "-in", "request.pem", "-CA", (authority / "ca.pem").string(), "-CAkey",
                   (authority / "key.pem").string(), "-CAcreateserial", "-CAserial", (authority / "serial").string(),
                   "-days", std::to_string(options.valid_days), "-sha256", "-out", "certificate.pem"});
  fs::remove(folder / "request.pem");
  fs::copy_file(authority / "ca.pem", folder / "ca.pem");
  atomic_write(folder / "governance.xml", governance_xml(options.domain));
  sign(folder, authority, "governance");
  atomic_write(folder / "permissions.xml", permissions_xml(station, options.domain, options.valid_days));
  sign(folder, authority, "permissions");
}

void check(const KeyOptions& options) {
  for (const std::string& station : options.stations) {
    link::StationParams params;
    params.station = station;
    config::check(params, "--robots " + station);
    if (station == kAuthority) throw InputError("a station cannot be called authority");
    if (fs::exists(options.out / station)) {
      throw InputError(
          fmt::format("{} is there already; remove it to make {} new keys", (options.out / station).string(), station));
    }
    if (std::count(options.stations.begin(), options.stations.end(), station) > 1) {
      throw InputError(station + " is named twice");
    }
  }
}

}  // namespace

void make_keys(const KeyOptions& options) {
  check(options);
  if (!fs::exists(options.out / kAuthority)) make_authority(options.out / kAuthority, options.valid_days);
  for (const std::string& station : options.stations) make_station(options, station);
}

}  // namespace arpent::tools
