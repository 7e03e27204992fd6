// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/team/keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>

#include "common/error.h"
#include "link/dds_settings.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// What a command prints, and "exit N" if it failed.
std::string run(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  std::string said;
  std::array<char, 4096> buffer{};
  while (fgets(buffer.data(), buffer.size(), pipe) != nullptr) said += buffer.data();
  const int status = pclose(pipe);
  return status == 0 ? said : said + "exit " + std::to_string(status);
}

class TeamKeys : public testing::Test {
 protected:
  void SetUp() override { make_keys({.out = folder_, .stations = {"R1", "centre"}, .domain = 7}); }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& file) const { return (folder_ / file).string(); }

  fs::path folder_ = fs::temp_directory_path() / ("arpent_keys_" + std::to_string(getpid()));
};

TEST_F(TeamKeys, OpensslAgreesWithEveryCertificateAndSignature) {
  for (const std::string station : {"R1", "centre"}) {
    EXPECT_THAT(run("openssl verify -CAfile " + path("authority/ca.pem") + " " + path(station + "/certificate.pem")),
                HasSubstr("OK"));
    EXPECT_THAT(run("openssl x509 -noout -subject -nameopt RFC2253 -in " + path(station + "/certificate.pem")),
                HasSubstr("subject=CN=" + station + ",O=arpent"));
    for (const std::string document : {"governance", "permissions"}) {
      EXPECT_THAT(run("openssl smime -verify -text -CAfile " + path(station + "/ca.pem") + " -in " +
                      path(station + "/" + document + ".p7s")),
                  HasSubstr("successful"));
    }
    EXPECT_THAT(run("openssl smime -verify -text -CAfile " + path(station + "/ca.pem") + " -in " +
                    path(station + "/permissions.p7s")),
                HasSubstr("<subject_name>CN=" + station + ",O=arpent</subject_name>"));
  }
}

TEST_F(TeamKeys, AStationsFolderHasAllThatTheLinkAsksForAndNothingOfTheAuthoritysKey) {
  link::LinkParams params;
  params.keys = folder_ / "R1";
  EXPECT_EQ(link::security_properties(params).size(), std::size(link::kKeyFiles) + 9);
  EXPECT_NE(run("cat " + path("R1/key.pem")), run("cat " + path("authority/key.pem")));
  EXPECT_EQ(fs::status(folder_ / "R1/key.pem").permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(fs::status(folder_ / "authority").permissions(), fs::perms::owner_all);
}

TEST_F(TeamKeys, AStationThatComesLaterGetsKeysOfTheSameAuthority) {
  const std::string authority = run("cat " + path("authority/ca.pem"));
  make_keys({.out = folder_, .stations = {"R2"}, .domain = 7});
  EXPECT_EQ(run("cat " + path("R2/ca.pem")), authority);
}

TEST_F(TeamKeys, KeysThatAreThereAreNotReplacedAndNamesThatCannotBeAreRefused) {
  const auto make = [&](const std::vector<std::string>& stations) {
    make_keys({.out = folder_, .stations = stations});
  };
  EXPECT_THROW(make({"R1"}), InputError);
  EXPECT_THROW(make({"../R9"}), InputError);
  EXPECT_THROW(make({"authority"}), InputError);
  EXPECT_THROW(make({"R5", "R5"}), InputError);
  EXPECT_FALSE(fs::exists(folder_ / "R5"));
}

}  // namespace
}  // namespace arpent::tools
