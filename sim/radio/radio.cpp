// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/radio/radio.h"

#include <algorithm>

#include "common/config/config.h"

namespace arpent::sim {

Radio::Radio(const RadioParams& params, std::uint64_t seed) : params_(params), random_(seed) {
  config::check(params, "radio");
}

bool Radio::lost() {
  return static_cast<double>(random_() >> 11) * 0x1p-53 < params_.loss;
}

void Radio::send(Time now, const std::string& sender, const std::string& channel,
                 const std::vector<std::string>& receivers, bool reliable, RadioBytes bytes) {
  const auto size = static_cast<std::int64_t>(bytes->size());
  const std::int64_t frames = std::max<std::int64_t>(1, (size + params_.frame_bytes - 1) / params_.frame_bytes);
  const std::int64_t on_air = size + frames * params_.frame_overhead_bytes;
  std::int64_t& counted = bytes_[channel];
  counted += on_air;
  Time& free_at = sender_free_at_[sender];
  free_at = std::max(free_at, now) + from_seconds(8e-6 * static_cast<double>(on_air) / params_.rate_mbps);
  for (const std::string& receiver : receivers) {
    int attempts = 1;  // of the frame that needs most
    bool gone = false;
    for (std::int64_t f = 0; f < frames; ++f) {
      int needed = 1;
      for (; lost() && !gone; ++needed) {
        gone = !reliable;
        if (reliable) counted += params_.frame_bytes + params_.frame_overhead_bytes;
      }
      attempts = std::max(attempts, needed);
    }
    if (gone) continue;
    Time at = free_at + from_seconds(params_.delay_s + params_.repair_s * (attempts - 1));
    if (reliable) {
      Time& last = last_in_order_[sender + "/" + channel + "/" + receiver];
      last = at = std::max(at, last);
    }
    on_the_way_.emplace(std::pair(at, ++order_), Delivery{at, order_, receiver, channel, bytes});
  }
}

std::vector<Radio::Delivery> Radio::take(Time now) {
  std::vector<Delivery> arrived;
  while (!on_the_way_.empty() && on_the_way_.begin()->first.first <= now) {
    arrived.push_back(std::move(on_the_way_.begin()->second));
    on_the_way_.erase(on_the_way_.begin());
  }
  return arrived;
}

}  // namespace arpent::sim
