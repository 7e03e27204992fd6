// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/socketcan_port.h"

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/net_tstamp.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "drivers/can/kernel_frame.h"

namespace arpent::can {
namespace {

constexpr can_err_mask_t kErrors =
    CAN_ERR_TX_TIMEOUT | CAN_ERR_CRTL | CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_ACK | CAN_ERR_BUSERROR;
/// A time of arrival that lies further back than this is not believed.
constexpr Duration kMostAge{1000000};

std::int64_t to_us(const timespec& t) {
  return t.tv_sec * 1000000LL + t.tv_nsec / 1000;
}

struct Received {
  can_frame frame{};
  Duration age{0};  ///< since the kernel took it from the controller
  std::optional<std::uint32_t> overflows;
  int error = 0;  ///< errno, EAGAIN if nothing waits
};

/// The kernel stamps with the date, which can be set at any time: only the age is used, held to what can be.
Duration age_of(const timespec& stamp) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return std::clamp(Duration(to_us(now) - to_us(stamp)), Duration(0), kMostAge);
}

Received read_one(int fd) {
  Received received;
  iovec part{&received.frame, sizeof(received.frame)};
  alignas(cmsghdr) char control[256];
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof(control);
  const ssize_t size = recvmsg(fd, &message, 0);
  if (size != static_cast<ssize_t>(sizeof(received.frame))) {
    received.error = size < 0 ? errno : EAGAIN;
    return received;
  }
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SO_TIMESTAMPING) {
      timespec stamps[3];
      std::memcpy(stamps, CMSG_DATA(c), sizeof(stamps));
      received.age = age_of(stamps[0]);
    } else if (c->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t lost = 0;
      std::memcpy(&lost, CMSG_DATA(c), sizeof(lost));
      received.overflows = lost;
    }
  }
  return received;
}

}  // namespace

SocketCanPort::SocketCanPort(std::string interface, std::vector<std::uint32_t> heard_ids, Now now)
    : interface_(std::move(interface)), heard_ids_(std::move(heard_ids)), now_(std::move(now)) {
  if (retry_.due(now_())) open();
}

/// Reason why the socket cannot be used, empty if it can.
std::string SocketCanPort::configure(int fd) const {
  std::vector<can_filter> filters;
  // Without EFF and RTR in the mask, extended frames with the same low bits would pass.
  for (const std::uint32_t id : heard_ids_) filters.push_back({id, CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK});
  if (!filters.empty()) {
    setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
               static_cast<socklen_t>(filters.size() * sizeof(can_filter)));
  }
  setsockopt(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &kErrors, sizeof(kErrors));
  const int stamps = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE, on = 1;
  setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPING, &stamps, sizeof(stamps));
  setsockopt(fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof(on));
  ifreq request{};
  interface_.copy(request.ifr_name, IFNAMSIZ - 1);
  if (ioctl(fd, SIOCGIFINDEX, &request) != 0) return "there is no interface " + interface_ + " (ip link)";
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = request.ifr_ifindex;
  if (ioctl(fd, SIOCGIFFLAGS, &request) != 0 || (request.ifr_flags & IFF_UP) == 0) {
    return interface_ + " is down (ip link set " + interface_ + " up)";
  }
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    return interface_ + " cannot be used: " + std::strerror(errno);
  }
  return "";
}

void SocketCanPort::open() {
  FileDescriptor fd(socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!fd) return give_up(std::string("this kernel opens no CAN socket: ") + std::strerror(errno));
  const std::string reason = configure(fd.get());
  if (!reason.empty()) return give_up(reason);
  socket_ = std::move(fd);
  state_ = PortState::kActive;
  fault_.clear();
  kernel_overflows_ = 0;
  if (was_open_) ++counters_.restarts;
  was_open_ = true;
}

void SocketCanPort::give_up(const std::string& reason) {
  socket_.close();
  state_ = PortState::kGone;
  fault_ = reason;
}

void SocketCanPort::lose(int error) {
  give_up(interface_ + " went away: " + std::strerror(error));
}

bool SocketCanPort::send(const CanFrame& frame) {
  if (!socket_ && retry_.due(now_())) open();
  const can_frame kernel = to_kernel(frame);
  const bool takes = socket_ && state_ <= PortState::kPassive && frame.size <= kMaxBytes;
  if (takes && write(socket_.get(), &kernel, sizeof(kernel)) == sizeof(kernel)) return true;
  ++counters_.refused;
  if (takes && errno != ENOBUFS && errno != EAGAIN && errno != EINTR) lose(errno);
  return false;
}

std::optional<LoggedFrame> SocketCanPort::receive() {
  if (!socket_ && retry_.due(now_())) open();
  while (socket_) {
    const Received received = read_one(socket_.get());
    if (received.error == EINTR) continue;
    if (received.error == EAGAIN) return std::nullopt;
    if (received.error != 0) {
      lose(received.error);
      return std::nullopt;
    }
    if (received.overflows)
      counters_.overflows += *received.overflows - std::exchange(kernel_overflows_, *received.overflows);
    if (is_error_frame(received.frame)) {
      state_ = take_error_frame(received.frame, state_, counters_);
    } else if (const auto frame = from_kernel(received.frame)) {
      // Traffic after bus-off: the controller takes part again, even if its driver did not say so.
      if (state_ == PortState::kBusOff) {
        state_ = PortState::kActive;
        ++counters_.restarts;
      }
      return LoggedFrame{now_() - received.age, interface_, *frame};
    }
  }
  return std::nullopt;
}

}  // namespace arpent::can
