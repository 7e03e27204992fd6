// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <termios.h>

#include <cerrno>
#include <cstring>

#include "common/error.h"
#include "drivers/base/wifibot_chassis.h"
#include "tools/can_mock/mock.h"

namespace arpent::tools {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// The board's end of a line.
class Line {
 public:
  virtual ~Line() = default;
  [[nodiscard]] virtual std::vector<int> descriptors() const = 0;
  virtual void serve(base::WifibotChassis& chassis, Time now) = 0;
};

FileDescriptor serve_socket(int type, int port) {
  FileDescriptor fd(socket(AF_INET, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int on = 1;
  setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  if (bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    throw InputError(fmt::format("can-mock: port {} cannot be used: {}", port, std::strerror(errno)));
  }
  return fd;
}

/// As over the network: without the sync byte.
Bytes bare(const base::WifibotChassis& chassis) {
  const Bytes frame = chassis.telemetry();
  return {frame.begin() + 1, frame.end()};
}

/// The vendor's server answers every packet that it receives with one of telemetry.
class TcpLine : public Line {
 public:
  explicit TcpLine(int port) : listener_(serve_socket(SOCK_STREAM, port)) { listen(listener_.get(), 1); }
  std::vector<int> descriptors() const override { return {listener_.get(), client_.get()}; }
  void serve(base::WifibotChassis& chassis, Time now) override {
    FileDescriptor next(accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (next) client_ = std::move(next);
    std::uint8_t bytes[256];
    ssize_t size = 0;
    while (client_ && (size = recv(client_.get(), bytes, sizeof(bytes), 0)) > 0) {
      chassis.receive({bytes, static_cast<std::size_t>(size)}, now);
      const Bytes answer = bare(chassis);
      (void)send(client_.get(), answer.data(), answer.size(), MSG_NOSIGNAL);
    }
    if (client_ && (size == 0 || errno != EAGAIN)) client_.close();
  }

 private:
  FileDescriptor listener_, client_;
};

class UdpLine : public Line {
 public:
  explicit UdpLine(int port)
      : commands_(serve_socket(SOCK_DGRAM, port)), telemetry_(serve_socket(SOCK_DGRAM, port + 10)) {}
  std::vector<int> descriptors() const override { return {commands_.get(), telemetry_.get()}; }
  void serve(base::WifibotChassis& chassis, Time now) override {
    std::uint8_t bytes[256];
    ssize_t size = 0;
    while ((size = recv(commands_.get(), bytes, sizeof(bytes), 0)) > 0) {
      chassis.receive({bytes, static_cast<std::size_t>(size)}, now);
    }
    sockaddr_in from{};
    socklen_t length = sizeof(from);
    auto* const address = reinterpret_cast<sockaddr*>(&from);
    while ((size = recvfrom(telemetry_.get(), bytes, sizeof(bytes), 0, address, &length)) > 0) {
      const bool greeting = size == 4 && std::memcmp(bytes, "init", 4) == 0;
      const Bytes answer = greeting ? Bytes{'o', 'k'} : bare(chassis);
      (void)sendto(telemetry_.get(), answer.data(), answer.size(), 0, address, length);
    }
  }

 private:
  FileDescriptor commands_, telemetry_;
};

/// A pseudo-terminal: telemetry flows by itself, every 22 ms.
class SerialLine : public Line {
 public:
  explicit SerialLine(const std::string& link) : link_(link), board_(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    if (!board_ || grantpt(board_.get()) != 0 || unlockpt(board_.get()) != 0) {
      throw InputError(std::string("can-mock: no pseudo-terminal: ") + std::strerror(errno));
    }
    // Held open, so that a driver that leaves is no hang-up.
    device_ = FileDescriptor(open(ptsname(board_.get()), O_RDWR | O_NOCTTY | O_CLOEXEC));
    termios raw{};
    tcgetattr(device_.get(), &raw);
    cfmakeraw(&raw);
    tcsetattr(device_.get(), TCSANOW, &raw);
    if (symlink(ptsname(board_.get()), link.c_str()) != 0) {
      throw InputError("can-mock: the link " + link + " cannot be made: " + std::strerror(errno));
    }
  }
  ~SerialLine() override { unlink(link_.c_str()); }
  std::vector<int> descriptors() const override { return {board_.get()}; }
  void serve(base::WifibotChassis& chassis, Time now) override {
    std::uint8_t bytes[256];
    ssize_t size = 0;
    while ((size = read(board_.get(), bytes, sizeof(bytes))) > 0) {
      chassis.receive({bytes, static_cast<std::size_t>(size)}, now);
    }
    constexpr Duration kPeriod{22000};
    if (now - told_at_ < kPeriod) return;
    told_at_ = now;
    const Bytes frame = chassis.telemetry();
    // Nobody reads: what does not fit is lost, as on a line.
    (void)!write(board_.get(), frame.data(), frame.size());
  }

 private:
  std::string link_;
  FileDescriptor board_, device_;
  Time told_at_{};
};

std::unique_ptr<Line> make_line(const std::string& listen) {
  const std::size_t colon = listen.find(':');
  const std::string kind = listen.substr(0, colon), rest = colon == std::string::npos ? "" : listen.substr(colon + 1);
  if (kind == "serial" && !rest.empty()) return std::make_unique<SerialLine>(rest);
  const auto port = to_number(rest);
  const bool usable = port && *port >= 1 && *port <= 65525;
  if (kind == "tcp" && usable) return std::make_unique<TcpLine>(static_cast<int>(*port));
  if (kind == "udp" && usable) return std::make_unique<UdpLine>(static_cast<int>(*port));
  throw InputError("can-mock: --listen '" + listen + "': must be tcp:PORT, udp:PORT or serial:LINK for a Wifibot");
}

class WifibotMock : public Mock {
 public:
  explicit WifibotMock(const MockOptions& options, const Now& now)
      : now_(now), line_(make_line(options.listen)), chassis_(params_of(options)) {}

  void wait(Duration longest) override {
    std::vector<pollfd> fds;
    for (const int fd : line_->descriptors()) fds.push_back({fd, POLLIN, 0});
    const timespec timeout{0, longest.count() * 1000};
    ppoll(fds.data(), fds.size(), &timeout, nullptr);
    line_->serve(chassis_, now_());
  }
  void step(Time now, double duration_s) override { chassis_.step(now, duration_s); }
  base::WheelMotors& motors() override { return chassis_.motors(); }
  std::string condition() override { return chassis_.telemetry()[0] == 0xFF ? "classic framing" : "0xFE framing"; }

 protected:
  bool apply_own(const Words& /*words*/) override { return false; }

 private:
  static base::WifibotChassisParams params_of(const MockOptions& options) {
    base::WifibotChassisParams params;
    params.motors = options.motors;
    params.motors.counts_per_m = options.base.wifibot.odometer_ticks_per_m;
    params.command_ticks_per_mps = options.base.wifibot.command_ticks_per_mps;
    return params;
  }

  Now now_;
  std::unique_ptr<Line> line_;
  base::WifibotChassis chassis_;
};

}  // namespace

std::unique_ptr<Mock> make_wifibot_mock(const MockOptions& options, const Now& now) {
  return std::make_unique<WifibotMock>(options, now);
}

}  // namespace arpent::tools
