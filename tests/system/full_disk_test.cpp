// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A mission whose disk fills up: the log ends, map, certificate and report do not. The small disk is a tmpfs in a mount
// namespace of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/system/live_program.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class FullDisk : public testing::Test {
 protected:
  FullDisk() { fs::create_directories(folder_ / "disk"); }
  void SetUp() override {
    if (on_disk_of(1, "true") != 0) GTEST_SKIP() << "no mount namespace here: " << program_.said();
  }
  ~FullDisk() override { fs::remove_all(folder_); }

  /// Runs `script` with a disk of so many MB in $DISK; its exit code.
  int on_disk_of(int megabytes, const std::string& script) {
    const std::string disk = (folder_ / "disk").string();
    program_.start({"/usr/bin/unshare", "--user", "--map-root-user", "--mount", "/bin/sh", "-c",
                    "mount -t tmpfs -o size=" + std::to_string(megabytes) + "m tmpfs " + disk +
                        " || exit; DISK=" + disk + "; " + script});
    return program_.exit_code(std::chrono::seconds(180));
  }

  const std::string mission_ = ARPENT_BIN_DIR "/arpent-mission " ARPENT_SOURCE_DIR
                                              "/config/missions/test_arena.yaml --sensing depth --out $DISK/out";
  fs::path folder_ = fs::temp_directory_path() / ("arpent_full_disk_" + std::to_string(getpid()));
  LiveProgram program_{folder_ / "said"};
};

TEST_F(FullDisk, TheLogEndsAndTheMapDoesNot) {
  const int code = on_disk_of(36, mission_ +
                                      " --set mission.max_time_s=25; echo code $?; cd $DISK/out; ls -A; "
                                      "test -s mesh.ply -a -s certificate.json -a -s report.html");
  EXPECT_EQ(code, 0) << program_.said();
  EXPECT_THAT(program_.said(), HasSubstr("the disk takes no more"));
  EXPECT_THAT(program_.said(), HasSubstr("mission.lcmlog is not complete: No space left on device"));
  EXPECT_THAT(program_.said(), HasSubstr("code 1"));
  EXPECT_THAT(program_.said(), testing::Not(HasSubstr(".reserve")));
}

TEST_F(FullDisk, TooSmallADiskIsOneErrorBeforeAnythingStarts) {
  const int code = on_disk_of(8, mission_ + "; echo code $?; ls -A $DISK/out");
  EXPECT_EQ(code, 0) << program_.said();
  EXPECT_THAT(program_.said(), HasSubstr("cannot keep 32 MB for the map in"));
  EXPECT_THAT(program_.said(), HasSubstr("code 2"));
  EXPECT_THAT(program_.said(), testing::Not(HasSubstr("mission.lcmlog")));
}

}  // namespace
}  // namespace arpent
