// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/launch/launcher.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "common/error.h"

namespace arpent::tools {
namespace {

using namespace std::chrono_literals;

class LauncherTest : public testing::Test {
 protected:
  std::filesystem::path log_file_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".log");

  [[nodiscard]] std::string log() const {
    std::stringstream text;
    text << std::ifstream(log_file_).rdbuf();
    return text.str();
  }

  template <class Done>
  static void poll_until(Launcher& launcher, Done done) {
    const auto limit = std::chrono::steady_clock::now() + 10s;
    while (!done() && std::chrono::steady_clock::now() < limit) launcher.poll(20);
  }
};

TEST_F(LauncherTest, GathersOutputOfAllProcessesInOneLog) {
  Launcher launcher(log_file_);
  launcher.start({"one", {"/bin/sh", "-c", "echo hello; echo again >&2"}, false});
  launcher.start({"two", {"/bin/sh", "-c", "echo world"}, false});
  poll_until(launcher, [&] { return !launcher.running("one") && !launcher.running("two"); });
  for (const char* word : {"one", "two", "hello", "again", "world", "ended with code 0"}) {
    EXPECT_NE(log().find(word), std::string::npos) << word;
  }
}

TEST_F(LauncherTest, RestartsWhatEndsAndGivesUpOnACrashLoop) {
  Launcher launcher(log_file_);
  launcher.start({"crash", {"/bin/sh", "-c", "exit 3"}, true});
  poll_until(launcher, [&] { return launcher.children()[0].gave_up; });
  EXPECT_TRUE(launcher.children()[0].gave_up);
  EXPECT_EQ(launcher.children()[0].restarts, 3);
  EXPECT_EQ(launcher.children()[0].exit_code, 3);
}

TEST_F(LauncherTest, StopsGentlyAndKillsOnlyWhatDoesNotListen) {
  Launcher launcher(log_file_);
  launcher.start({"gentle", {"/bin/sh", "-c", "trap 'echo bye; exit 0' TERM; while :; do sleep 0.05; done"}, true});
  launcher.start({"deaf", {"/bin/sh", "-c", "trap '' TERM; echo ready; while :; do sleep 0.05; done"}, true});
  poll_until(launcher, [&] { return log().find("ready") != std::string::npos; });
  EXPECT_EQ(launcher.stop_all(500), 1);
  EXPECT_FALSE(launcher.running("gentle"));
  EXPECT_FALSE(launcher.running("deaf"));
  EXPECT_NE(log().find("bye"), std::string::npos);
}

TEST_F(LauncherTest, AnExecutableThatIsNotThereIsOneClearError) {
  Launcher launcher(log_file_);
  EXPECT_THROW(launcher.start({"none", {"/no/such/file"}, true}), InputError);
}

}  // namespace
}  // namespace arpent::tools
