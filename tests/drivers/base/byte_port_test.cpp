// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Serial lines (a pseudo-terminal), TCP and UDP against real ends, with a clock of the test's own for retries.
#include "drivers/base/byte_port.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/socket.h>

#include "common/error.h"

namespace arpent::base {
namespace {

using Bytes = std::vector<std::uint8_t>;
const Bytes kCommand{0xFF, 0x07, 0x0A, 0x0D, 0x11, 0x13, 0x00, 0x1A, 0x03};  // bytes that a cooked line would eat

class BytePortTest : public testing::Test {
 protected:
  Time now_ = from_utime(1'000'000);
  Now clock_ = [this] { return now_; };

  void later() { now_ += Duration(200'000); }
  /// Reads as many bytes as wanted, or what comes within a second.
  static Bytes read_from(int fd, std::size_t wanted) {
    Bytes bytes(wanted);
    std::size_t got = 0;
    pollfd ready{fd, POLLIN, 0};
    while (got < wanted && poll(&ready, 1, 1000) == 1) {
      const ssize_t size = read(fd, bytes.data() + got, wanted - got);
      if (size <= 0) break;
      got += static_cast<std::size_t>(size);
    }
    bytes.resize(got);
    return bytes;
  }
  static Bytes receive_some(BytePort& port) {
    for (int i = 0; i < 1000; ++i) {
      Bytes bytes = port.receive();
      if (!bytes.empty()) return bytes;
      usleep(1000);
    }
    return {};
  }
  /// A socket on a port of the kernel's choice, or on the given one.
  static FileDescriptor serve(int type, std::uint16_t& port) {
    FileDescriptor fd(socket(AF_INET, type, 0));
    const int on = 1;
    setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    if (bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) fd.close();
    socklen_t size = sizeof(address);
    getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    if (type == SOCK_STREAM) listen(fd.get(), 1);
    return fd;
  }
};

TEST_F(BytePortTest, ASerialLinePassesEveryByteBothWays) {
  const FileDescriptor board(posix_openpt(O_RDWR | O_NOCTTY));
  ASSERT_TRUE(board);
  ASSERT_EQ(grantpt(board.get()), 0);
  ASSERT_EQ(unlockpt(board.get()), 0);
  const auto port = open_byte_port("serial:" + std::string(ptsname(board.get())), clock_);
  ASSERT_TRUE(port->send(kCommand)) << port->fault();
  EXPECT_EQ(read_from(board.get(), kCommand.size()), kCommand);
  ASSERT_EQ(write(board.get(), kCommand.data(), kCommand.size()), static_cast<ssize_t>(kCommand.size()));
  EXPECT_EQ(receive_some(*port), kCommand);
  EXPECT_FALSE(port->bare_telemetry());
}

TEST_F(BytePortTest, ADeviceThatIsNotThereIsSaidAndTriedAgain) {
  const auto port = open_byte_port("serial:/dev/no_such_line", clock_);
  EXPECT_FALSE(port->send(kCommand));
  EXPECT_FALSE(port->open());
  EXPECT_NE(port->fault().find("/dev/no_such_line"), std::string::npos);
  const auto file = open_byte_port("serial:/dev/null", clock_);
  EXPECT_FALSE(file->send(kCommand)) << "no terminal";
}

TEST_F(BytePortTest, TcpConnectsSendsHearsAndConnectsAgain) {
  std::uint16_t number = 0;
  FileDescriptor server = serve(SOCK_STREAM, number);
  const auto port = open_byte_port("tcp:127.0.0.1:" + std::to_string(number), clock_);
  EXPECT_TRUE(port->bare_telemetry());
  (void)port->receive();
  FileDescriptor board(accept(server.get(), nullptr, nullptr));
  ASSERT_TRUE(port->open());
  ASSERT_TRUE(port->send(kCommand));
  EXPECT_EQ(read_from(board.get(), kCommand.size()), kCommand);
  ASSERT_EQ(write(board.get(), "abc", 3), 3);
  EXPECT_EQ(receive_some(*port), (Bytes{'a', 'b', 'c'}));
  board.close();
  for (int i = 0; i < 1000 && port->open(); ++i) {
    (void)port->receive();
    usleep(1000);
  }
  EXPECT_FALSE(port->open());
  EXPECT_NE(port->fault(), "");
  later();
  (void)port->receive();
  const FileDescriptor again(accept(server.get(), nullptr, nullptr));
  EXPECT_TRUE(port->send(kCommand));
}

TEST_F(BytePortTest, UdpGreetsTheTelemetryPortAndAsksWithEveryCommand) {
  std::uint16_t number = 0, telemetry_number = 0;
  FileDescriptor commands, telemetry;
  for (int i = 0; i < 20 && !telemetry; ++i) {
    number = 0;
    commands = serve(SOCK_DGRAM, number);
    telemetry_number = static_cast<std::uint16_t>(number + 10);
    telemetry = serve(SOCK_DGRAM, telemetry_number);
  }
  ASSERT_TRUE(telemetry);
  const auto port = open_byte_port("udp:127.0.0.1:" + std::to_string(number), clock_);
  ASSERT_TRUE(port->send(kCommand));
  EXPECT_EQ(read_from(commands.get(), kCommand.size()), kCommand);
  const auto answer = [&](const std::string& expected, const std::string& reply) {
    char request[16];
    sockaddr_in from{};
    socklen_t size = sizeof(from);
    const ssize_t length =
        recvfrom(telemetry.get(), request, sizeof(request), 0, reinterpret_cast<sockaddr*>(&from), &size);
    EXPECT_EQ(std::string(request, static_cast<std::size_t>(std::max<ssize_t>(length, 0))), expected);
    sendto(telemetry.get(), reply.data(), reply.size(), 0, reinterpret_cast<const sockaddr*>(&from), size);
  };
  answer("init", "ok");
  for (int i = 0; i < 100; ++i) (void)port->receive();
  ASSERT_TRUE(port->send(kCommand));
  answer("data", "telemetry");
  EXPECT_EQ(receive_some(*port).size(), 9U);
}

TEST_F(BytePortTest, NonsenseIsRefused) {
  for (const char* spec : {"", "serial:", "tcp:", "tcp:wifibot", "tcp:1.2.3.4:0", "tcp:1.2.3.4:99999", "udp:1.2.3",
                           "can0", "tcp:1.2.3.4:15020x"}) {
    EXPECT_THROW((void)open_byte_port(spec, clock_), InputError) << spec;
  }
  EXPECT_NO_THROW((void)open_byte_port("udp:192.168.1.106", clock_));
}

}  // namespace
}  // namespace arpent::base
