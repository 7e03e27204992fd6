// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/candump.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "common/atomic_file.h"
#include "common/error.h"
#include "drivers/can/memory_bus.h"

namespace arpent::can {
namespace {

using testing::HasSubstr;

class CandumpTest : public testing::Test {
 protected:
  ~CandumpTest() override { std::filesystem::remove(file_); }
  std::filesystem::path file_ = testing::TempDir() + "/candump_" + std::to_string(getpid()) + "_" +
                                testing::UnitTest::GetInstance()->current_test_info()->name();
  Time now_ = from_utime(5'000'000);
  Now clock_ = [this] { return now_; };
};

TEST_F(CandumpTest, ALogPlaysAtItsOwnPaceOnTheClockOfToday) {
  atomic_write(file_,
               "(1436509053.850870) can0 111#0096000000000000\n"
               "(1436509053.860870) can0 20000040#0000000000000000\n"  // bus-off
               "(1436509053.860870) can0 211#R\n"                      // remote
               "(1436509053.950870) can0 00000117#0000C738\n");
  CandumpPort port(file_, clock_);
  EXPECT_EQ(port.state(), PortState::kActive);
  const auto first = port.receive();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->stamp, now_);
  EXPECT_EQ(to_text(first->frame), "111#0096000000000000");
  now_ += Duration(99'999);
  EXPECT_FALSE(port.receive());
  now_ += Duration(1);
  const auto second = port.receive();
  ASSERT_TRUE(second);
  EXPECT_EQ(to_text(second->frame), "00000117#0000C738");
  EXPECT_EQ(port.state(), PortState::kGone);
  EXPECT_THAT(port.fault(), HasSubstr("end"));
}

TEST_F(CandumpTest, ALineThatIsNoFrameIsNamed) {
  atomic_write(file_, "(1436509053.850870) can0 111#00\n(1436509053.85) can0 111#00\n");
  try {
    CandumpPort port(file_, clock_);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(":2: not a line of candump -l"));
  }
  EXPECT_THROW(CandumpPort("/no/such/log", clock_), InputError);
}

TEST_F(CandumpTest, WhatWasRecordedPlaysBack) {
  MemoryBus bus({.delay = Duration(0)});
  const auto other = bus.open("other");
  {
    RecordingPort port(bus.open("driver"), file_, clock_);
    EXPECT_TRUE(port.send(*from_text("421#01")));
    EXPECT_TRUE(other->send(*from_text("211#0001020304050607")));
    bus.advance(now_);
    EXPECT_TRUE(port.receive());
    bus.set_state("driver", PortState::kBusOff);
    EXPECT_FALSE(port.send(*from_text("111#00"))) << "was not sent, is not in the log";
  }
  const auto frames = read_candump(file_);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(to_text(frames[0].frame), "421#01");
  EXPECT_EQ(to_text(frames[1].frame), "211#0001020304050607");
  EXPECT_THROW(RecordingPort(bus.open("driver"), "/no/such/folder/log", clock_), InputError);
}

}  // namespace
}  // namespace arpent::can
