// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/live_capture.h"

#include <fmt/format.h>

#include <csignal>
#include <cstdio>

#include "common/bus/lcm_bus.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"

namespace arpent::tools {
namespace {

volatile std::sig_atomic_t g_stop = 0;  // set by the signal handler only

}  // namespace

LiveCapture::LiveCapture(Bus& bus, const calib::Target& target, Say say, const calib::CoachParams& params)
    : target_(target), detector_(target), params_(params), say_(std::move(say)) {
  // Only the newest pair counts: the search for the board is slower than a camera.
  subscribe<stereo_images_t>(bus, channels::kStereoImages, {.queue_capacity = 1},
                             [this](const stereo_images_t& message) {
                               const auto pair = stereo::from_wire(message);
                               if (pair) return on_pair(*pair);
                               tell("a pair that cannot be used: " + pair.fault());
                             });
}

const calib::BoardViews& LiveCapture::views() const {
  if (!coach_) throw InputError("no STEREO_IMAGES came: is camera_process running, on this bus?");
  return coach_->views();
}

void LiveCapture::on_pair(const stereo::StereoPair& pair) {
  if (!coach_) {
    coach_.emplace(target_,
                   std::vector<calib::CameraInput>{{"left", pair.left.cols, pair.left.rows},
                                                   {"right", pair.right.cols, pair.right.rows}},
                   params_);
  }
  const calib::CameraInput& camera = coach_->views().cameras[0];
  if (pair.left.cols != camera.width_px || pair.left.rows != camera.height_px) {
    return tell(fmt::format("mixed sizes: a pair of {} x {} among {} x {}", pair.left.cols, pair.left.rows,
                            camera.width_px, camera.height_px));
  }
  tell(coach_->offer(
      {fmt::format("{}", to_utime(pair.stamp)), {detector_.detect(pair.left), detector_.detect(pair.right)}}));
}

void LiveCapture::tell(const std::string& line) {
  if (line == last_) return;
  last_ = line;
  say_(line);
}

calib::BoardViews capture_live(const std::string& lcm_url, const calib::Target& target) {
  std::signal(SIGINT, [](int) { g_stop = 1; });
  LcmBus bus(lcm_url);
  LiveCapture capture(bus, target, [](const std::string& line) {
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
  });
  std::printf("waiting for STEREO_IMAGES; Ctrl-C calibrates with what was taken\n");
  bus.start();
  while (g_stop == 0 && !capture.complete()) bus.run_for(Duration(50000));
  return capture.views();
}

}  // namespace arpent::tools
