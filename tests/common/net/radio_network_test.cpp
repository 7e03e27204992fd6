// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// Networks that are kept open: work and processes enter them, and see that network alone.
#include "common/net/radio_network.h"

#include <gtest/gtest.h>
#include <net/if.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>

#include "common/net/tap_hub.h"

namespace arpent {
namespace {

std::filesystem::path network_of_this_thread() {
  return std::filesystem::read_symlink("/proc/thread-self/ns/net");
}

class RadioNetworkTest : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string refused = radio_network_refused(); !refused.empty()) GTEST_SKIP() << refused;
  }
};

TEST_F(RadioNetworkTest, WorkIsInsideAndTheCallerStaysOutside) {
  const auto outside = network_of_this_thread();
  RadioNetwork one("10.77.0.1"), other("10.77.0.2");
  std::filesystem::path in_one, in_other, again;
  run_in_network(one.network_fd(), [&] { in_one = network_of_this_thread(); });
  run_in_network(other.network_fd(), [&] {
    in_other = network_of_this_thread();
    EXPECT_GT(if_nametoindex("radio0"), 0U);
  });
  run_in_network(one.network_fd(), [&] { again = network_of_this_thread(); });
  EXPECT_EQ(network_of_this_thread(), outside);
  EXPECT_NE(in_one, outside);
  EXPECT_NE(in_one, in_other);
  EXPECT_EQ(in_one, again);
  run_in_network(-1, [&] { EXPECT_EQ(network_of_this_thread(), outside); });
}

TEST_F(RadioNetworkTest, WhatWorkThrowsComesOut) {
  const RadioNetwork one("10.77.0.1");
  EXPECT_THROW(run_in_network(one.network_fd(), [] { throw std::runtime_error("no"); }), std::runtime_error);
}

TEST_F(RadioNetworkTest, TheTapIsHandedOverOnce) {
  RadioNetwork one("10.77.0.1");
  const int tap = one.release_tap();
  EXPECT_GE(tap, 0);
  EXPECT_EQ(one.release_tap(), -1);
  close(tap);
}

}  // namespace
}  // namespace arpent
