// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/launch/launcher.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

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

TEST_F(LauncherTest, AKilledProcessStaysDead) {
  Launcher launcher(log_file_);
  launcher.start({"victim", {"/bin/sleep", "30"}, true});
  launcher.kill("victim");
  launcher.poll(20);
  const Launcher::Child& child = launcher.children()[0];
  EXPECT_EQ(child.pid, -1);
  EXPECT_EQ(child.exit_code, 128 + SIGKILL);
  EXPECT_TRUE(child.killed);
  EXPECT_EQ(child.restarts, 0);
}

TEST_F(LauncherTest, ANetworkThatIsNoneIsNotEntered) {
  Launcher launcher(log_file_);
  const int no_network = open("/dev/null", O_RDONLY | O_CLOEXEC);
  launcher.start({"lost", {"/bin/sh", "-c", "echo ran"}, false, no_network});
  poll_until(launcher, [&] { return !launcher.running("lost"); });
  close(no_network);
  EXPECT_EQ(launcher.children()[0].exit_code, 126);
  EXPECT_EQ(log().find("ran\n"), std::string::npos);
}

/// A shell that stops at once sends SIGTERM before the child has become its program.
TEST_F(LauncherTest, WhatHasJustBeenStartedStopsAsGently) {
  for (int i = 0; i < 20; ++i) {
    Launcher launcher(log_file_);
    launcher.start({"sleeper", {"/bin/sleep", "30"}, true});
    EXPECT_TRUE(launcher.stop("sleeper", 5000));
  }
}

TEST_F(LauncherTest, ChildrenDoNotHearTheTerminal) {
  Launcher launcher(log_file_);
  launcher.start({"child", {"/bin/sh", "-c", "echo ready; sleep 30"}, true});
  poll_until(launcher, [&] { return log().find("ready") != std::string::npos; });
  EXPECT_EQ(getpgid(launcher.children()[0].pid), launcher.children()[0].pid);
}

TEST_F(LauncherTest, AtAnOrderlyEndNothingIsStartedAgain) {
  Launcher launcher(log_file_);
  launcher.start({"brief", {"/bin/sh", "-c", "sleep 0.1"}, true});
  launcher.start({"long", {"/bin/sleep", "30"}, true});
  launcher.restart_no_more();
  poll_until(launcher, [&] { return !launcher.running("brief"); });
  EXPECT_TRUE(launcher.stop("long", 5000));
  EXPECT_EQ(launcher.children()[0].restarts, 0);
}

TEST_F(LauncherTest, AnExecutableThatIsNotThereIsOneClearError) {
  Launcher launcher(log_file_);
  EXPECT_THROW(launcher.start({"none", {"/no/such/file"}, true}), InputError);
}

}  // namespace
}  // namespace arpent::tools
