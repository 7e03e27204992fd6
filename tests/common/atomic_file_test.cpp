// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <sstream>
#include <vector>

#include "common/error.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;

class AtomicFileTest : public testing::Test {
 protected:
  AtomicFileTest() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~AtomicFileTest() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string content() const {
    std::stringstream text;
    text << std::ifstream(file_).rdbuf();
    return text.str();
  }
  [[nodiscard]] std::ptrdiff_t files() const { return std::distance(fs::directory_iterator(folder_), {}); }

  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("atomic_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  fs::path file_ = folder_ / "file";
};

/// A disk on which files can have no more than `bytes`, as long as this lives.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST_F(AtomicFileTest, ReplacesTheWholeFile) {
  atomic_write(file_, "first and long");
  atomic_write(file_, "second");
  EXPECT_EQ(content(), "second");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, AFullDiskLeavesTheOldFileAndNothingElse) {
  atomic_write(file_, "old");
  {
    const SmallDisk disk(10000);
    EXPECT_THROW(atomic_write(file_, std::string(20000, 'x')), InputError);
  }
  EXPECT_EQ(content(), "old");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, AProducerThatFailsLeavesTheOldFile) {
  atomic_write(file_, "old");
  EXPECT_THROW(atomic_write(file_,
                            [](const WriteBytes& write) {
                              write(std::as_bytes(std::span(std::string_view("half"))));
                              throw std::runtime_error("changed my mind");
                            }),
               std::runtime_error);
  EXPECT_EQ(content(), "old");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, AFolderThatIsNotThereIsOneClearError) {
  try {
    atomic_write(folder_ / "no" / "file", "x");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no/file"), std::string::npos);
  }
}

}  // namespace
}  // namespace arpent
