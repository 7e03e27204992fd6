// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A radio that is not there: messages from one station to others, with delay, a limited rate, and frames that get lost.
// It behaves as the transport that was measured (Cyclone DDS over multicast): a reliable message loses time where it
// loses frames and keeps its order, an unreliable one is gone.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "common/config/fields.h"
#include "common/time.h"

namespace arpent::sim {

struct RadioParams {
  double loss = 0.02;
  double delay_s = 0.02;
  double repair_s = 0.12;
  double rate_mbps = 5.0;
  int frame_bytes = 1100;
  int frame_overhead_bytes = 190;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("loss", self.loss, "share of frames that are lost, for each receiver by itself",
                  config::between(0.0, 0.95));
    visitor.field("delay_s", self.delay_s, "one way", config::between(0.0, 10.0));
    visitor.field("repair_s", self.repair_s, "from a lost frame to its next attempt", config::between(0.0, 10.0));
    visitor.field("rate_mbps", self.rate_mbps, "of one sender", config::greater_than(0.0));
    visitor.field("frame_bytes", self.frame_bytes, "payload of a frame", config::between(64, 65000));
    visitor.field("frame_overhead_bytes", self.frame_overhead_bytes, "headers and the seal of a frame",
                  config::between(0, 10000));
  }
};

using RadioBytes = std::shared_ptr<const std::vector<std::uint8_t>>;  // shared: one message has several receivers

class Radio {
 public:
  struct Delivery {
    Time time;
    std::int64_t order = 0;
    std::string receiver;
    std::string channel;
    RadioBytes bytes;
  };

  /// Throws InputError for parameters that break their rules. The same calls with the same seed give the same
  /// deliveries.
  Radio(const RadioParams& params, std::uint64_t seed);

  /// Once over the air for all receivers (multicast); lost frames of reliable messages again.
  void send(Time now, const std::string& sender, const std::string& channel, const std::vector<std::string>& receivers,
            bool reliable, RadioBytes bytes);
  /// What has arrived by now, in the order of arrival.
  [[nodiscard]] std::vector<Delivery> take(Time now);

  /// On the air so far, repairs and overhead included.
  [[nodiscard]] const std::map<std::string, std::int64_t>& bytes_by_channel() const { return bytes_; }

 private:
  [[nodiscard]] bool lost();

  RadioParams params_;
  std::mt19937_64 random_;
  std::map<std::string, Time> sender_free_at_;
  std::map<std::string, Time> last_in_order_;  ///< of a reliable channel, by sender, channel and receiver
  std::map<std::pair<Time, std::int64_t>, Delivery> on_the_way_;
  std::int64_t order_ = 0;
  std::map<std::string, std::int64_t> bytes_;
};

}  // namespace arpent::sim
