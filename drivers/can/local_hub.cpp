// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/local_hub.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <cerrno>
#include <cstring>
#include <vector>

#include "common/error.h"
#include "drivers/can/kernel_frame.h"

namespace arpent::can {
namespace {

constexpr int kBacklog = 8;

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  if (path.empty() || path.size() >= sizeof(address.sun_path)) {
    throw InputError("CAN socket '" + path + "': a path of 1 to " + std::to_string(sizeof(address.sun_path) - 1) +
                     " characters is needed");
  }
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, path.size());
  return address;
}

FileDescriptor connect_to(const std::string& path) {
  const sockaddr_un address = address_of(path);
  FileDescriptor fd(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (fd && connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) fd.close();
  return fd;
}

enum class Io : std::uint8_t { kDone, kNothing, kClosed };

Io read_frame(int fd, can_frame& frame) {
  const ssize_t size = recv(fd, &frame, sizeof(frame), 0);
  if (size == sizeof(frame)) return Io::kDone;
  return size < 0 && (errno == EAGAIN || errno == EINTR) ? Io::kNothing : Io::kClosed;
}

Io write_frame(int fd, const can_frame& frame) {
  if (::send(fd, &frame, sizeof(frame), MSG_NOSIGNAL) == sizeof(frame)) return Io::kDone;
  return errno == EAGAIN || errno == EINTR || errno == ENOBUFS ? Io::kNothing : Io::kClosed;
}

}  // namespace

struct LocalHub::State {
  struct Client {
    FileDescriptor socket;
    std::unique_ptr<CanPort> place;
  };

  std::string path;
  Now now;
  MemoryBus bus{{.delay = Duration(0)}};
  std::unique_ptr<CanPort> own = bus.open("hub");
  FileDescriptor listener;
  std::vector<Client> clients;
  PortState client_state = PortState::kActive;

  void accept_all() {
    for (;;) {
      FileDescriptor fd(accept4(listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (!fd) return;
      if (client_state == PortState::kGone) continue;
      clients.push_back({std::move(fd), bus.open("client")});
      bus.set_state("client", client_state);
      if (client_state != PortState::kActive)
        (void)write_frame(clients.back().socket.get(), make_error_frame(client_state));
    }
  }

  void read_all() {
    for (Client& client : clients) {
      can_frame kernel{};
      Io io = Io::kDone;
      while ((io = read_frame(client.socket.get(), kernel)) == Io::kDone) {
        // What a controller that is off the bus was given is lost.
        if (const auto frame = from_kernel(kernel)) (void)client.place->send(*frame);
      }
      if (io == Io::kClosed) client.socket.close();
    }
  }

  void write_all() {
    for (Client& client : clients) {
      while (const auto frame = client.place->receive()) {
        if (client.socket && write_frame(client.socket.get(), to_kernel(frame->frame)) == Io::kClosed)
          client.socket.close();
      }
    }
    std::erase_if(clients, [](const Client& client) { return !client.socket; });
  }

  void forward() {
    accept_all();
    read_all();
    bus.advance(now());
    write_all();
  }
};

LocalHub::LocalHub(const std::string& path, Now now) : state_(std::make_unique<State>()) {
  const sockaddr_un address = address_of(path);
  if (connect_to(path)) throw InputError("CAN socket " + path + ": another stand-in of the base is there already");
  unlink(path.c_str());
  state_->path = path;
  state_->now = std::move(now);
  state_->listener = FileDescriptor(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (bind(state_->listener.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      listen(state_->listener.get(), kBacklog) != 0) {
    throw InputError("CAN socket " + path + " cannot be made: " + std::strerror(errno));
  }
}

LocalHub::~LocalHub() {
  unlink(state_->path.c_str());
}

bool LocalHub::send(const CanFrame& frame) {
  const bool taken = state_->own->send(frame);
  state_->forward();
  return taken;
}

std::optional<LoggedFrame> LocalHub::receive() {
  if (auto frame = state_->own->receive()) return frame;
  state_->forward();
  return state_->own->receive();
}

PortState LocalHub::state() const {
  return state_->own->state();
}

PortCounters LocalHub::counters() const {
  return state_->own->counters();
}

void LocalHub::wait(Duration longest) {
  std::vector<pollfd> fds{{state_->listener.get(), POLLIN, 0}};
  for (const State::Client& client : state_->clients) fds.push_back({client.socket.get(), POLLIN, 0});
  const timespec timeout{longest.count() / 1000000, longest.count() % 1000000 * 1000};
  if (longest > Duration(0)) ppoll(fds.data(), fds.size(), &timeout, nullptr);
  state_->forward();
}

void LocalHub::set_faults(const BusFaults& faults) {
  state_->bus.set_faults(faults);
}

void LocalHub::set_client_state(PortState state) {
  if (state_->client_state == state) return;
  state_->client_state = state;
  state_->bus.set_state("client", state);
  if (state == PortState::kGone) state_->clients.clear();
  for (State::Client& client : state_->clients) (void)write_frame(client.socket.get(), make_error_frame(state));
}

int LocalHub::clients() const {
  return static_cast<int>(state_->clients.size());
}

LocalPort::LocalPort(std::string path, Now now) : path_(std::move(path)), now_(std::move(now)) {
  (void)address_of(path_);
  if (retry_.due(now_())) open();
}

void LocalPort::open() {
  socket_ = connect_to(path_);
  if (!socket_) return lose("no stand-in of the base listens at " + path_ + ": " + std::strerror(errno));
  state_ = PortState::kActive;
  fault_.clear();
  if (was_open_) ++counters_.restarts;
  was_open_ = true;
}

void LocalPort::lose(const std::string& reason) {
  socket_.close();
  state_ = PortState::kGone;
  fault_ = reason;
}

bool LocalPort::send(const CanFrame& frame) {
  if (!socket_ && retry_.due(now_())) open();
  const bool takes = socket_ && state_ <= PortState::kPassive && frame.size <= kMaxBytes;
  const Io io = takes ? write_frame(socket_.get(), to_kernel(frame)) : Io::kNothing;
  if (io == Io::kDone) return true;
  ++counters_.refused;
  if (io == Io::kClosed) lose("the stand-in of the base at " + path_ + " went away");
  return false;
}

std::optional<LoggedFrame> LocalPort::receive() {
  if (!socket_ && retry_.due(now_())) open();
  while (socket_) {
    can_frame kernel{};
    const Io io = read_frame(socket_.get(), kernel);
    if (io == Io::kClosed) lose("the stand-in of the base at " + path_ + " went away");
    if (io != Io::kDone) return std::nullopt;
    if (is_error_frame(kernel)) {
      state_ = take_error_frame(kernel, state_, counters_);
    } else if (const auto frame = from_kernel(kernel)) {
      return LoggedFrame{now_(), "socket", *frame};
    }
  }
  return std::nullopt;
}

}  // namespace arpent::can
