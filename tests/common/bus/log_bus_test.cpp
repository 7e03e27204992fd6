// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/log_bus.h"

#include <gtest/gtest.h>

#include "common/error.h"

namespace arpent {
namespace {

using namespace std::chrono_literals;

std::string file(const std::string& name) {
  return testing::TempDir() + "log_bus_" + name + ".lcmlog";
}

TEST(LogBus, HandlesTheLogInOrderAndWritesWhatIsPublished) {
  {
    LogWriter writer(file("in"));
    for (int i = 0; i < 5; ++i)
      writer.write(from_utime(100000LL * i), i % 2 == 0 ? "A" : "B", Bytes{static_cast<std::uint8_t>(i)});
    writer.write(from_utime(350000), "A", Bytes{9});  // times of real logs go back
    writer.write(from_utime(500000), "A", Bytes(50, 1));
    writer.close();
  }
  LogBus bus(file("in"), file("out"));
  std::vector<int> seen, rings;
  bus.subscribe_bytes("A", {8, 10, Duration(0)}, [&](BytesView bytes) {
    seen.push_back(bytes[0]);
    bus.publish_bytes("OUT", bytes);
  });
  bus.every(150ms, [&] { rings.push_back(static_cast<int>(to_utime(bus.now()) / 1000)); });
  bus.run();
  EXPECT_EQ(seen, (std::vector<int>{0, 2, 4, 9}));
  EXPECT_EQ(rings, (std::vector<int>{150, 300, 450}));
  EXPECT_EQ(bus.health().counter("A", "undecodable"), 1) << "above the size limit";
  LogReader reader(file("out"));
  std::vector<std::pair<std::int64_t, int>> written;
  while (const auto event = reader.next()) written.emplace_back(to_utime(event->time), event->data[0]);
  EXPECT_EQ(written, (std::vector<std::pair<std::int64_t, int>>{{0, 0}, {200000, 2}, {400000, 4}, {400000, 9}}));
}

TEST(LogBus, ALogThatIsNotThereIsOneClearError) {
  EXPECT_THROW(LogBus("/no/such/log", ""), InputError);
}

}  // namespace
}  // namespace arpent
