// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// Unit files: what they start and how, and that systemd itself finds no fault with them where it is at hand.
#include "tools/launch/systemd.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "common/atomic_file.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::vector<ProcessSpec> kProcesses{{"sh", {"/bin/sh", "--set", "a=100% $HOME \"quoted\" back\\slash"}, true},
                                          {"sh", {"/bin/sh", "--lcm-url", "udpm://239.255.76.67:7667?ttl=0"}, false}};

TEST(SystemdUnits, EachProcessIsAServiceAndOneTargetWantsThemAll) {
  const auto units = to_units(kProcesses, "/srv/robot");
  ASSERT_EQ(units.size(), 3U);
  EXPECT_EQ(units[0].name, "arpent-sh.service");
  EXPECT_EQ(units[1].name, "arpent-sh-2.service");
  EXPECT_THAT(units[0].text, HasSubstr(R"(ExecStart="/bin/sh" "--set" "a=100%% $$HOME \"quoted\" back\\slash")"));
  EXPECT_THAT(units[0].text, HasSubstr("WorkingDirectory=/srv/robot\nRestart=always\n"));
  EXPECT_THAT(units[1].text, HasSubstr("Restart=no\n"));
  EXPECT_EQ(units[2].name, "arpent.target");
  EXPECT_THAT(units[2].text, HasSubstr("Wants=arpent-sh.service arpent-sh-2.service\n"));
}

TEST(SystemdUnits, SystemdAcceptsThem) {
  if (std::system("command -v systemd-analyze >/dev/null 2>&1") != 0) GTEST_SKIP() << "no systemd-analyze here";
  const fs::path folder = fs::path(testing::TempDir()) / "systemd_units";
  fs::create_directories(folder);
  std::string files;
  for (const UnitFile& unit : to_units(kProcesses, folder)) {
    atomic_write(folder / unit.name, unit.text);
    files += " " + (folder / unit.name).string();
  }
  const std::string said = (folder / "said").string();
  (void)std::system(
      ("SYSTEMD_LOG_LEVEL=warning systemd-analyze verify --man=no" + files + " >" + said + " 2>&1").c_str());
  // Units of the machine itself may have faults: only what is said of ours counts.
  EXPECT_NE(std::system(("grep arpent " + said).c_str()), 0);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace arpent::tools
