// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/byte_port.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>

#include "common/error.h"

namespace arpent::base {
namespace {

constexpr std::uint16_t kTcpPort = 15020, kUdpPort = 15000, kUdpTelemetryOffset = 10;

bool try_again(int error) {
  return error == EAGAIN || error == EINTR || error == ENOBUFS;
}

/// What all of them share: when to open, when to give up.
class ReopeningPort : public BytePort {
 public:
  explicit ReopeningPort(Now now) : now_(std::move(now)) {}

  bool send(std::span<const std::uint8_t> bytes) override {
    if (!ready()) return false;
    const ssize_t sent = write_some(bytes);
    if (sent < 0 && !try_again(errno)) lose(std::strerror(errno));
    return sent == static_cast<ssize_t>(bytes.size());
  }
  std::vector<std::uint8_t> receive() override {
    std::vector<std::uint8_t> bytes;
    std::uint8_t chunk[1024];
    while (ready()) {
      const ssize_t size = read_some(chunk);
      if (size > 0) bytes.insert(bytes.end(), chunk, chunk + size);
      if (size < 0 && !try_again(errno)) lose(std::strerror(errno));
      if (size <= 0) break;
    }
    return bytes;
  }
  bool open() const override { return static_cast<bool>(fd_); }
  std::string fault() const override { return fault_; }

 protected:
  /// Opens `fd_`, or says why it cannot.
  virtual std::string attempt() = 0;
  virtual ssize_t write_some(std::span<const std::uint8_t> bytes) {
    return ::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  virtual ssize_t read_some(std::span<std::uint8_t> bytes) { return recv(fd_.get(), bytes.data(), bytes.size(), 0); }

  bool ready() {
    if (!fd_ && retry_.due(now_())) {
      fault_ = attempt();
      if (!fault_.empty()) fd_.close();
    }
    return static_cast<bool>(fd_);
  }
  void lose(const std::string& reason) {
    fd_.close();
    fault_ = reason;
  }

  FileDescriptor fd_;

 private:
  Now now_;
  RetryTimer retry_;
  std::string fault_ = "not opened yet";
};

class SerialPort : public ReopeningPort {
 public:
  SerialPort(std::string device, Now now) : ReopeningPort(std::move(now)), device_(std::move(device)) {}
  /// 22 bytes of 10 bits at 19200 baud.
  Duration frame_time() const override { return Duration(11500); }

 protected:
  std::string attempt() override {
    fd_ = FileDescriptor(::open(device_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    termios line{};
    if (!fd_ || tcgetattr(fd_.get(), &line) != 0) return device_ + ": " + std::strerror(errno);
    cfmakeraw(&line);
    line.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | PARENB | CRTSCTS);
    line.c_cflag |= CLOCAL | CREAD;
    cfsetspeed(&line, B19200);
    if (tcsetattr(fd_.get(), TCSANOW, &line) != 0) return device_ + ": " + std::strerror(errno);
    tcflush(fd_.get(), TCIOFLUSH);
    return "";
  }
  ssize_t write_some(std::span<const std::uint8_t> bytes) override {
    return write(fd_.get(), bytes.data(), bytes.size());
  }
  ssize_t read_some(std::span<std::uint8_t> bytes) override { return read(fd_.get(), bytes.data(), bytes.size()); }

 private:
  std::string device_;
};

struct Address {
  std::string text;
  sockaddr_in value{};
};

FileDescriptor connected_socket(int type, sockaddr_in address, std::uint16_t port) {
  address.sin_port = htons(port);
  FileDescriptor fd(socket(AF_INET, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (fd && connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 &&
      errno != EINPROGRESS) {
    fd.close();
  }
  return fd;
}

class TcpPort : public ReopeningPort {
 public:
  TcpPort(const Address& address, std::uint16_t port, Now now)
      : ReopeningPort(std::move(now)), address_(address), port_(port) {}
  bool bare_telemetry() const override { return true; }
  bool open() const override {
    // A connection that is still being made takes nothing.
    pollfd fd{fd_.get(), POLLOUT, 0};
    return fd_ && poll(&fd, 1, 0) == 1 && (fd.revents & (POLLERR | POLLHUP)) == 0;
  }

 protected:
  std::string attempt() override {
    fd_ = connected_socket(SOCK_STREAM, address_.value, port_);
    if (!fd_) return address_.text + ": " + std::strerror(errno);
    const int on = 1;
    setsockopt(fd_.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
    return "";
  }
  ssize_t read_some(std::span<std::uint8_t> bytes) override {
    const ssize_t size = recv(fd_.get(), bytes.data(), bytes.size(), 0);
    if (size == 0) lose(address_.text + " closed the connection");
    return size;
  }

 private:
  Address address_;
  std::uint16_t port_;
};

/// Commands on one port; on the other, "init" is answered by "ok", and then every "data" by telemetry.
class UdpPort : public ReopeningPort {
 public:
  UdpPort(const Address& address, std::uint16_t port, Now now)
      : ReopeningPort(std::move(now)), address_(address), port_(port) {}
  bool bare_telemetry() const override { return true; }

 protected:
  std::string attempt() override {
    fd_ = connected_socket(SOCK_DGRAM, address_.value, port_);
    telemetry_ = connected_socket(SOCK_DGRAM, address_.value, static_cast<std::uint16_t>(port_ + kUdpTelemetryOffset));
    greeted_ = false;
    return fd_ && telemetry_ ? "" : address_.text + ": " + std::strerror(errno);
  }
  ssize_t write_some(std::span<const std::uint8_t> bytes) override {
    const std::string_view request = greeted_ ? "data" : "init";
    const bool asked = ::send(telemetry_.get(), request.data(), request.size(), MSG_NOSIGNAL) >= 0;
    const ssize_t sent = ReopeningPort::write_some(bytes);
    return asked ? sent : -1;
  }
  ssize_t read_some(std::span<std::uint8_t> bytes) override {
    const ssize_t size = recv(telemetry_.get(), bytes.data(), bytes.size(), 0);
    if (size != 2 || bytes[0] != 'o' || bytes[1] != 'k') return size;
    greeted_ = true;
    return recv(telemetry_.get(), bytes.data(), bytes.size(), 0);
  }

 private:
  Address address_;
  std::uint16_t port_;
  FileDescriptor telemetry_;
  bool greeted_ = false;
};

struct NetworkSpec {
  Address address;
  std::uint16_t port;
};

std::optional<NetworkSpec> parse_network(const std::string& text, std::uint16_t default_port) {
  const std::size_t colon = text.find(':');
  NetworkSpec spec{{text.substr(0, colon), {}}, default_port};
  spec.address.value.sin_family = AF_INET;
  if (inet_pton(AF_INET, spec.address.text.c_str(), &spec.address.value.sin_addr) != 1) return std::nullopt;
  if (colon == std::string::npos) return spec;
  const char *begin = text.data() + colon + 1, *end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, spec.port);
  if (error != std::errc() || stop != end || spec.port == 0) return std::nullopt;
  return spec;
}

}  // namespace

std::unique_ptr<BytePort> open_byte_port(const std::string& spec, const Now& now) {
  const std::size_t colon = spec.find(':');
  const std::string kind = spec.substr(0, colon);
  const std::string rest = colon == std::string::npos ? "" : spec.substr(colon + 1);
  if (kind == "serial" && !rest.empty()) return std::make_unique<SerialPort>(rest, now);
  if (kind == "tcp") {
    if (const auto to = parse_network(rest, kTcpPort)) return std::make_unique<TcpPort>(to->address, to->port, now);
  }
  if (kind == "udp") {
    if (const auto to = parse_network(rest, kUdpPort)) return std::make_unique<UdpPort>(to->address, to->port, now);
  }
  throw InputError("port '" + spec +
                   "' of the base: must be serial:DEVICE, tcp:ADDRESS[:PORT] or udp:ADDRESS[:PORT], " +
                   "with a numeric address");
}

}  // namespace arpent::base
