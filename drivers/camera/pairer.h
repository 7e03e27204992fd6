// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Pairs from the frames of two cameras: by frame counter or by device time, never by order of arrival. Arrival only
// serves to relate the two devices' clocks to ours (clock_map.h), which says at the start which frames belong together;
// from then on counters or device times decide, and every pair's device times must agree within the tolerance. A frame
// without a partner is a lost half: counted, never completed with another.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "common/config/fields.h"
#include "drivers/camera/clock_map.h"
#include "drivers/camera/frame_counter.h"
#include "drivers/camera/frame_source.h"

namespace arpent::camera {

enum class Side : std::uint8_t { kLeft = 0, kRight = 1 };

struct PairerParams {
  std::string by = "frame_id";
  std::string clocks = "separate";
  double tolerance_s = 0.002;
  int queue = 8;
  int warm_up_frames = 5;
  double transfer_s = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("by", self.by, "what says that two frames belong together",
                  config::one_of({"frame_id", "device_time"}));
    visitor.field("clocks", self.clocks,
                  "separate: each camera has its own; shared: one clock stamps both (PTP); bus: the stamps are in the "
                  "bus' time (files, V4L2)",
                  config::one_of({"separate", "shared", "bus"}));
    visitor.field("tolerance_s", self.tolerance_s, "most that the two exposures of a pair may start apart",
                  config::between(1e-6, 1.0));
    visitor.field("queue", self.queue, "frames of one camera that wait for the other's", config::between(1, 100));
    visitor.field("warm_up_frames", self.warm_up_frames,
                  "frames of each camera that must have come in time before separate clocks are related",
                  config::between(1, 100));
    visitor.field("transfer_s", self.transfer_s, "shortest time from the end of the exposure to the frame's arrival",
                  config::between(0.0, 1.0));
  }
};

struct FramePair {
  Frame left;
  Frame right;
  std::int64_t sequence = 0;  ///< counts the moments at which the cameras took a pair: a gap is lost pairs
  Time stamp;                 ///< middle of the exposure, in the bus' time
  Duration skew{0};           ///< right less left start of exposure, as far as the clocks can tell
};

/// Since the start. Index by Side.
struct PairerCounts {
  std::int64_t pairs = 0;
  std::int64_t out_of_tolerance = 0;        ///< pairs dropped because their times disagree
  std::array<std::int64_t, 2> unpaired{};   ///< halves dropped: the other side's frame never came
  std::array<std::int64_t, 2> missed{};     ///< frames that the device counted but nobody saw
  std::array<std::int64_t, 2> repeated{};   ///< frames with the id of the one before: a frozen device
  std::array<std::int64_t, 2> overtaken{};  ///< frames older than one that was already here
  std::int64_t warm_up = 0;                 ///< frames used up to relate the clocks
  std::int64_t locks = 0;                   ///< times that the two counters were related anew
};

class Pairer {
 public:
  explicit Pairer(const PairerParams& params) : params_(params) {}

  void add(Side side, Frame frame);
  /// The pairs made since the last call, in order.
  [[nodiscard]] std::vector<FramePair> take();
  [[nodiscard]] const PairerCounts& counts() const { return counts_; }

 private:
  struct Waiting {
    Frame frame;
    std::int64_t count;
  };
  struct Stream {
    FrameCounter counter;
    ClockMap clock;
    std::int64_t session = 0;
    std::optional<Waiting> last;
    std::optional<Duration> period;  ///< of the device, from its own stamps
    std::deque<Waiting> waiting;
  };
  /// What relates the two devices once it is known.
  struct Lock {
    std::int64_t right_minus_left_count;
    Duration right_minus_left_clock;
  };

  [[nodiscard]] Stream& stream(Side side) { return streams_[static_cast<std::size_t>(side)]; }
  [[nodiscard]] Time host_time(const Stream& stream, Time device) const;
  void start_session(Stream& stream, const Frame& frame);
  bool admit(Side side, const Frame& frame);
  void drop_front(Side side);
  void match();
  void lock();
  [[nodiscard]] Duration half_period() const;
  [[nodiscard]] bool settled(const Stream& stream) const;
  /// < 0: the left frame is older than the right one; 0: they belong together.
  [[nodiscard]] int compare(const Waiting& left, const Waiting& right) const;
  void join(const Waiting& left, const Waiting& right);
  [[nodiscard]] std::int64_t next_sequence(const Waiting& left);

  PairerParams params_;
  std::array<Stream, 2> streams_;
  std::optional<Lock> lock_;
  int disagreements_ = 0;  ///< in a row
  std::optional<std::int64_t> last_sequence_;
  std::int64_t last_left_count_ = 0;
  std::int64_t last_left_session_ = 0;
  std::vector<FramePair> ready_;
  PairerCounts counts_;
};

}  // namespace arpent::camera
