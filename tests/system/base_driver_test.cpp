// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The base_driver_process executable: what it says to arguments that cannot be, and that a base that is not there does
// not end it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include "common/atomic_file.h"
#include "common/net/private_network.h"

namespace arpent {
namespace {

using testing::HasSubstr;

struct Outcome {
  int exit_code = -1;
  std::string output;
};

Outcome run(const std::string& arguments) {
  static const std::string not_private = enter_private_network();
  const std::string command = std::string(ARPENT_BIN_DIR) +
                              "/base_driver_process --lcm-url 'udpm://239.255.76.67:" + std::to_string(private_port()) +
                              "?ttl=0' " + arguments + " 2>&1";
  Outcome outcome;
  FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 256> chunk{};
  while (fgets(chunk.data(), chunk.size(), pipe) != nullptr) outcome.output += chunk.data();
  outcome.exit_code = WEXITSTATUS(pclose(pipe));
  return outcome;
}

const std::string kRobot = std::string("--set robot=") + ARPENT_SOURCE_DIR + "/config/robots/wifibot.yaml ";

TEST(BaseDriverExecutable, NonsenseEndsItWithCodeTwoAndOneLine) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "negative_track.yaml";
  atomic_write(file, std::string("rig: rig.yaml\nbase: {track_m: -0.4}\n"));
  for (const auto& [arguments, expected] :
       {std::pair<std::string, std::string>{"", "robot"},
        {kRobot + "--set port=nonsense:x", "CAN port 'nonsense:x'"},
        {kRobot + "--set port=candump:/no/such/log", "/no/such/log"},
        {"--set robot=" + file.string(), "track_m = -0.4, must be between 0.05 and 5"},
        {"--set robot=/no/such/robot.yaml", "/no/such/robot.yaml"}}) {
    const Outcome outcome = run(arguments + " --run-for-s 5");
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_THAT(outcome.output, HasSubstr(expected));
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
  }
  std::filesystem::remove(file);
}

TEST(BaseDriverExecutable, ABaseThatIsNotThereIsSaidAndDoesNotEndIt) {
  for (const char* port : {"nocan7", "socket:/no/such/hub"}) {
    const Outcome outcome = run(kRobot + "--set port=" + port + " --run-for-s 0.3");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("the CAN port is not there"));
  }
}

TEST(BaseDriverExecutable, ADryRunIsAFlag) {
  EXPECT_THAT(run(kRobot + "--dry-run --print-config").output, HasSubstr("dry_run: true"));
}

}  // namespace
}  // namespace arpent
