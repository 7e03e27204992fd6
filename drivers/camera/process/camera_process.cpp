// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/process/camera_process.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <optional>
#include <utility>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "drivers/camera/process/open_feeds.h"
#include "drivers/camera/v4l2_source.h"
#include "drivers/camera/wire.h"

namespace arpent {
namespace {

using namespace camera;

constexpr const char* kSides[] = {"left", "right"};
/// Without pairs for so long the robot is blind (fault F7).
constexpr Duration kBlind{1000000};

/// Files, and the kernel's cameras, are stamped in the bus' time whatever the configuration says.
PairerParams pairing(const CameraConfig& config) {
  PairerParams params = config.pairing;
  if (config.source != "aravis") params.clocks = "bus";
  return params;
}

double mean_level(const FramePair& pair) {
  return (cv::mean(pair.left.image)[0] + cv::mean(pair.right.image)[0]) / 2;
}

}  // namespace

struct CameraProcess::State {
  Bus& bus;
  Clock& clock;
  ExposureController exposure;
  Pairer pairer;
  std::vector<std::unique_ptr<Feed>> feeds;
  std::vector<FeedCondition> conditions;
  PairerCounts counted;
  Time last_pair;  ///< by the clock
  std::optional<Time> last_stamp;

  State(const Config& config, Bus& process_bus, Clock& process_clock)
      : bus(process_bus),
        clock(process_clock),
        exposure(config.exposure),
        pairer(pairing(config)),
        feeds(open_feeds(config, process_clock)),
        conditions(feeds.size()),
        last_pair(process_clock.now()) {}

  Health& health() { return bus.health(); }
  void count(const std::string& what, std::int64_t increment) {
    if (increment > 0) health().count(channels::kStereoImages, what, increment);
  }
  [[nodiscard]] std::string name(std::size_t feed) const {
    return feeds.size() == 1 ? "stereo camera" : std::string(kSides[feed]) + " camera";
  }

  void poll() {
    for (std::size_t i = 0; i < feeds.size(); ++i) {
      for (Frame& frame : feeds[i]->take()) add(i, std::move(frame));
      watch(i);
    }
    for (const FramePair& pair : pairer.take()) use(pair);
    report_pairing();
  }

  void add(std::size_t feed, Frame frame) {
    if (feeds.size() == 2) {
      pairer.add(static_cast<Side>(feed), std::move(frame));
      return;
    }
    auto [left, right] = split_halves(frame);
    pairer.add(Side::kLeft, std::move(left));
    pairer.add(Side::kRight, std::move(right));
  }

  void use(const FramePair& pair) {
    if (last_stamp && pair.stamp <= *last_stamp) {
      count("not_later", 1);
      return;
    }
    last_stamp = pair.stamp;
    last_pair = clock.now();
    if (pair.left.exposure_us != pair.right.exposure_us || pair.left.gain_db != pair.right.gain_db) {
      count("unequal_exposure", 1);
    }
    publish(bus, channels::kStereoImages, to_wire(pair));
    const auto setting = exposure.update({pair.left.exposure_us, pair.left.gain_db}, mean_level(pair));
    if (!setting) return;
    for (const auto& feed : feeds) feed->set_exposure(*setting);
  }

  /// What changed in a camera's condition since the last look.
  void watch(std::size_t i) {
    const FeedCondition now = feeds[i]->condition();
    const FeedCondition before = std::exchange(conditions[i], now);
    const std::string side = feeds.size() == 1 ? "both" : kSides[i];
    count("incomplete_" + side, now.incomplete - before.incomplete);
    count("overflow_" + side, now.dropped - before.dropped);
    if (now.openings > 1) count("reopened_" + side, now.openings - std::max<std::int64_t>(before.openings, 1));
    if (now.fault != before.fault) complain(i);
  }

  void complain(std::size_t i) {
    if (!conditions[i].fault.empty()) health().error(name(i) + ": " + conditions[i].fault);
  }

  void report_pairing() {
    const PairerCounts now = pairer.counts();
    const PairerCounts before = std::exchange(counted, now);
    count("out_of_tolerance", now.out_of_tolerance - before.out_of_tolerance);
    count("warm_up", now.warm_up - before.warm_up);
    if (now.locks > 1) count("related_anew", now.locks - std::max<std::int64_t>(before.locks, 1));
    for (std::size_t i = 0; i < 2; ++i) {
      const std::string side = kSides[i];
      count("unpaired_" + side, now.unpaired[i] - before.unpaired[i]);
      count("missed_" + side, now.missed[i] - before.missed[i]);
      count("overtaken_" + side, now.overtaken[i] - before.overtaken[i]);
      count("repeated_" + side, now.repeated[i] - before.repeated[i]);
      if (now.repeated[i] > before.repeated[i])
        health().error(side + " camera is frozen: it sends the same frame again");
    }
    if (now.out_of_tolerance > before.out_of_tolerance) {
      health().warn("a pair was dropped: its exposures did not begin together (trigger? pairing.tolerance_s)");
    }
  }

  /// Once a second: what is still wrong.
  void remind() {
    for (std::size_t i = 0; i < feeds.size(); ++i) complain(i);
    if (clock.now() - last_pair >= kBlind) health().error("no stereo pair for a second or more");
  }
};

CameraProcess::CameraProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  clock.every(Duration(config.poll_us), [this] { state_->poll(); });
  clock.every(std::chrono::seconds(1), [this] { state_->remind(); });
}

CameraProcess::~CameraProcess() = default;

void CameraProcess::finish() {
  state_->feeds.clear();
}

}  // namespace arpent
