// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A station's parameters as Cyclone DDS wants them: its configuration as XML, and the files of DDS Security.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "link/params.h"

namespace arpent::link {

/// Cyclone's configuration. The values are those that were measured to stand 20 % loss and cuts of 10 s.
[[nodiscard]] std::string cyclone_config(const LinkParams& params);

/// The files in a station's folder of keys, and what DDS Security calls them.
inline constexpr std::pair<const char*, const char*> kKeyFiles[] = {
    {"dds.sec.auth.identity_ca", "ca.pem"},          {"dds.sec.auth.identity_certificate", "certificate.pem"},
    {"dds.sec.auth.private_key", "key.pem"},         {"dds.sec.access.permissions_ca", "ca.pem"},
    {"dds.sec.access.governance", "governance.p7s"}, {"dds.sec.access.permissions", "permissions.p7s"}};

/// Properties of the participant's QoS, empty without security. Throws InputError if a file is missing.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> security_properties(const LinkParams& params);

}  // namespace arpent::link
