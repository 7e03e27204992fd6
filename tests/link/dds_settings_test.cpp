// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "link/dds_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/config.h"
#include "common/error.h"

namespace arpent::link {
namespace {

using testing::HasSubstr;
using testing::Not;

LinkParams params() {
  LinkParams params;
  params.interface = "wlan0";
  return params;
}

TEST(LinkSettings, MulticastIsWithoutPeersAndUnicastNamesThemAll) {
  EXPECT_THAT(cyclone_config(params()), HasSubstr("<AllowMulticast>true<"));
  EXPECT_THAT(cyclone_config(params()), Not(HasSubstr("<Peer ")));
  LinkParams unicast = params();
  unicast.peers = "10.0.0.1,10.0.0.2";
  EXPECT_THAT(cyclone_config(unicast), HasSubstr("<AllowMulticast>false<"));
  EXPECT_THAT(cyclone_config(unicast), HasSubstr("<Peer address=\"10.0.0.1\"/><Peer address=\"10.0.0.2\"/>"));
}

TEST(LinkSettings, ASealedPacketStillFitsIntoAFrame) {
  EXPECT_THAT(cyclone_config(params()), HasSubstr("<MaxMessageSize>1300B<"));
  LinkParams plain = params();
  plain.security = "off";
  EXPECT_THAT(cyclone_config(plain), HasSubstr("<MaxMessageSize>1400B<"));
}

TEST(LinkSettings, TextThatWouldChangeTheConfigurationIsRefused) {
  LinkParams bad = params();
  bad.interface = "x\"/><Evil";
  EXPECT_THROW(config::check(bad, "link"), InputError);
  bad = params();
  bad.peers = "10.0.0.1 10.0.0.2";
  EXPECT_THROW(config::check(bad, "link"), InputError);
}

TEST(LinkSettings, SecurityIsOnAndMissingKeysAreOneClearError) {
  try {
    (void)security_properties(params());
    FAIL() << "no keys, no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("./arpent team keys"));
  }
  LinkParams plain = params();
  plain.security = "off";
  EXPECT_TRUE(security_properties(plain).empty());
}

}  // namespace
}  // namespace arpent::link
