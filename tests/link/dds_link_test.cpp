// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The link's beginning and end, in a network namespace. What it carries is team_link_live_test's matter.
#include "link/dds_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <mutex>
#include <thread>

#include "common/error.h"
#include "common/net/private_network.h"
#include "common/net/tap_hub.h"

namespace arpent::link {
namespace {

using namespace std::chrono_literals;

TEST(DdsLink, ConnectsWhenItsInterfaceComesAndEndsThoughItHasGone) {
  if (const std::string refused = enter_private_network(); !refused.empty()) GTEST_SKIP() << refused;
  std::mutex mutex;
  std::string warning;
  LinkParams params;
  params.interface = "radio0";
  params.security = "off";
  DdsLink link(params, {[](const Beat&) {}, [](const Command&) {}, [](const Part&) {},
                        [&](const std::string& text) {
                          const std::lock_guard lock(mutex);
                          if (warning.empty()) warning = text;
                        }});
  std::this_thread::sleep_for(200ms);
  EXPECT_FALSE(link.connected());
  EXPECT_FALSE(link.write(Beat{.station = "R1"}));
  {
    const std::lock_guard lock(mutex);
    EXPECT_THAT(warning, testing::HasSubstr("there is no network interface radio0"));
  }
  const Result<int> tap = open_radio_interface("10.77.0.1");
  if (!tap) GTEST_SKIP() << tap.fault();
  for (int i = 0; i < 500 && !link.connected(); ++i) std::this_thread::sleep_for(10ms);
  EXPECT_TRUE(link.connected());
  EXPECT_TRUE(link.write(Beat{.station = "R1"}));
  close(*tap);  // the interface goes away; the link ends all the same
}

TEST(DdsLink, KeysThatAreMissingAreAnErrorAtOnce) {
  LinkParams params;
  params.interface = "lo";
  params.keys = "/nowhere";
  EXPECT_THROW(DdsLink(params, {}), InputError);
}

}  // namespace
}  // namespace arpent::link
