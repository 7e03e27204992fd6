// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A folder for a test and `./arpent calibrate` run in it.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace arpent::tools {

class VerbTest : public testing::Test {
 protected:
  explicit VerbTest(const std::string& name)
      : folder_(std::filesystem::temp_directory_path() / fmt::format("{}_{}", name, getpid())) {}
  void SetUp() override {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// Runs the verb; output and errors go to output_.
  int run(const std::string& arguments) {
    const std::string file = (folder_ / "output.txt").string();
    const int status =
        std::system(fmt::format("{}/arpent-calibrate {} > {} 2>&1", ARPENT_BIN_DIR, arguments, file).c_str());
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    output_ = text.str();
    return WEXITSTATUS(status);
  }

  std::filesystem::path folder_;
  std::string output_;
};

}  // namespace arpent::tools
