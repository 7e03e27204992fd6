// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `calibrate stereo --live`: STEREO_IMAGES from the bus to the coach (calib/coach.h), and what the coach says to the
// terminal.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "calib/coach.h"
#include "common/bus/bus.h"
#include "perception/stereo/wire.h"

namespace arpent::tools {

class LiveCapture {
 public:
  using Say = std::function<void(const std::string& line)>;
  /// `say` gets a line whenever the advice changes.
  LiveCapture(Bus& bus, const calib::Target& target, Say say, const calib::CoachParams& params = {});

  [[nodiscard]] bool complete() const { return coach_ && coach_->complete(); }
  /// What was taken. Throws InputError if no pictures came.
  [[nodiscard]] const calib::BoardViews& views() const;

 private:
  void on_pair(const stereo::StereoPair& pair);
  void tell(const std::string& line);

  calib::Target target_;
  calib::BoardDetector detector_;
  calib::CoachParams params_;
  Say say_;
  std::optional<calib::CaptureCoach> coach_;  ///< from the first pair on, whose size it needs
  std::string last_;
};

/// On the bus at `lcm_url` until the coach has all, or Ctrl-C. Throws InputError.
[[nodiscard]] calib::BoardViews capture_live(const std::string& lcm_url, const calib::Target& target);

}  // namespace arpent::tools
