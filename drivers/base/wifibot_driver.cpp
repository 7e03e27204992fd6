// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/wifibot_driver.h"

#include <cmath>

#include "common/error.h"

namespace arpent::base {
namespace {

constexpr double kBoardMaxMps = 2.0;
/// Speed is the way over so long: single ticks do not matter.
constexpr Duration kSpeedWindow{100000};
constexpr Duration kWakePeriod{1000000};

double fastest_side_mps(const DriverParams& params) {
  const MotionLimits& limits = params.gate.limits;
  return limits.max_speed_mps + 0.5 * params.geometry.track_m * limits.max_turn_rate_radps;
}

}  // namespace

WifibotDriver::WifibotDriver(const DriverParams& params, const WifibotConfig& config, BytePort& port)
    : BaseDriver(params, 1 / config.odometer_ticks_per_m, kBoardMaxMps),
      config_(config),
      port_(port),
      parser_(port.bare_telemetry()) {
  config::check(config, "base.wifibot");
  const double ticks = fastest_side_mps(params) * config.command_ticks_per_mps;
  if (ticks > wifibot::kMaxSpeedTicks) {
    throw InputError("base: the limits ask for " + std::to_string(std::lround(ticks)) +
                     " ticks at a side, the board takes " + std::to_string(wifibot::kMaxSpeedTicks) +
                     ": lower max_speed_mps, max_turn_rate_radps or command_ticks_per_mps");
  }
}

std::vector<std::string> WifibotDriver::step(Time now) {
  Faults faults;
  // On the average a frame has waited half a cycle for being read.
  const Time stamp = now - port_.frame_time() - kCycle / 2;
  const std::vector<wifibot::Report> reports = parser_.feed(port_.receive());
  if (!reports.empty()) {
    // Of several in one cycle the newest counts; odometers do not need the others.
    std::visit([&](const auto& report) { take(report, stamp, faults); }, reports.back());
    take_sign_of_life(now);
    measure_twist();
  }
  status_.bad_frames = parser_.skipped_bytes();
  watch_port(faults);
  judge_silence(now, faults);
  status_.commanded = gate_.output(now);
  wake(now);
  send_motion(status_.commanded);
  return faults;
}

void WifibotDriver::take(const wifibot::Telemetry& telemetry, Time stamp, Faults& faults) {
  status_.battery_v = telemetry.battery_v;
  take_odometers(telemetry.left_odometer_ticks, telemetry.right_odometer_ticks, stamp, faults);
}

void WifibotDriver::take(const wifibot::Stream& stream, Time stamp, Faults& faults) {
  status_.battery_v = stream.battery_v;
  take_odometers(stream.odometers_ticks[0], stream.odometers_ticks[1], stamp, faults);
}

void WifibotDriver::measure_twist() {
  ways_.push_back({status_.stamp, status_.left_m, status_.right_m});
  while (ways_.size() > 2 && ways_.back().stamp - ways_[1].stamp >= kSpeedWindow) ways_.pop_front();
  const double duration_s = to_seconds(ways_.back().stamp - ways_.front().stamp);
  if (duration_s <= 0) return;
  const double left_mps = (ways_.back().left_m - ways_.front().left_m) / duration_s;
  const double right_mps = (ways_.back().right_m - ways_.front().right_m) / duration_s;
  status_.twist = {0.5 * (left_mps + right_mps), (right_mps - left_mps) / geometry_.track_m};
}

void WifibotDriver::watch_port(Faults& faults) {
  const bool open = port_.open();
  if (!open && was_open_) {
    faults.push_back("the port of the base is not there: " + port_.fault());
    lose_port();
  }
  if (open && !was_open_) faults.emplace_back("the port of the base is open");
  was_open_ = open;
}

void WifibotDriver::wake(Time now) {
  const bool due = !woken_at_ || now - *woken_at_ >= kWakePeriod;
  if (!config_.wake_by_pid || status_.heard || !due) return;
  woken_at_ = now;
  send(wifibot::encode(wifibot::PidCommand{}));
}

void WifibotDriver::send_motion(const Twist2& twist) {
  const double turning = 0.5 * geometry_.track_m * twist.turn_rate_radps;
  const auto ticks = [&](double mps) { return static_cast<int>(std::lround(mps * config_.command_ticks_per_mps)); };
  wifibot::SpeedCommand command;
  command.left_ticks = ticks(twist.speed_mps - turning);
  command.right_ticks = ticks(twist.speed_mps + turning);
  send(wifibot::encode(command));
}

void WifibotDriver::send(std::span<const std::uint8_t> bytes) {
  if (!dry_run_ && !port_.send(bytes)) ++status_.refused_sends;
}

}  // namespace arpent::base
