// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A device's clock in terms of ours. A frame arrives at its device time plus an offset that drifts, plus a delay that
// is never negative and sometimes nearly nothing; so the line below all points (device time, arrival - device time)
// that lies closest to them is the offset (Moon, Skelly and Towsley, INFOCOM 1999; Zhang, Liu and Xia, INFOCOM 2002).
// It needs no knowledge of the jitter, however lopsided.
#pragma once

#include <deque>

#include "common/time.h"

namespace arpent::camera {

class ClockMap {
 public:
  /// The last `window` samples count.
  explicit ClockMap(std::size_t window = 100) : window_(window) {}

  /// `earliest`: arrival less what is known of the way (exposure, readout, transfer).
  void add(Time device, Time earliest);
  /// Our time of a moment of the device's. Needs a sample.
  [[nodiscard]] Time to_host(Time device) const;
  [[nodiscard]] std::size_t size() const { return samples_.size(); }
  /// Samples that came at most `within` after the earliest possible moment, as far as is known now: few of them mean
  /// that frames have been late so far and that the line still lies too high.
  [[nodiscard]] std::size_t prompt(Duration within) const;
  void clear() { samples_.clear(); }

 private:
  struct Sample {
    Time device;
    Duration delay;
  };
  std::size_t window_;
  std::deque<Sample> samples_;
  double rate_ = 0;       ///< seconds of offset gained in a second of the device's
  double offset_us_ = 0;  ///< at samples_.front().device, beyond its delay
  void fit();
};

}  // namespace arpent::camera
