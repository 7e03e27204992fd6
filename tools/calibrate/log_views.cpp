// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "calib/coach.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/log/event_log.h"
#include "perception/stereo/wire.h"
#include "tools/calibrate/files.h"
#include "tools/calibrate/motion_log.h"

namespace arpent::tools {
namespace {

/// `count` of the views, spread evenly.
void thin_out(std::vector<calib::View>& views, std::size_t count) {
  if (views.size() <= count) return;
  std::vector<calib::View> kept;
  for (std::size_t i = 0; i < count; ++i) kept.push_back(views[i * views.size() / count]);
  views = std::move(kept);
}

}  // namespace

calib::BoardViews views_from_log(const calib::Target& target, const std::filesystem::path& log, std::size_t most,
                                 const Progress& progress) {
  constexpr double kLeastMove = 0.02;  // of the image's width: what moved less adds nothing but weight
  LogReader reader(log);
  const calib::BoardDetector detector(target);
  calib::BoardViews views{target, {{"left", 0, 0}, {"right", 0, 0}}, {}};
  std::size_t pairs = 0;
  while (const auto event = reader.next()) {
    if (!is_channel(event->channel, channels::kStereoImages)) continue;
    stereo_images_t message;
    if (message.decode(event->data.data(), 0, static_cast<int>(event->data.size())) < 0) continue;
    const auto pair = stereo::from_wire(message);
    if (!pair) continue;
    ++pairs;
    progress(reader.position_bytes(), reader.size_bytes());
    if (views.cameras[0].width_px == 0) {
      for (auto& camera : views.cameras) camera.width_px = pair->left.cols, camera.height_px = pair->left.rows;
    }
    if (pair->left.cols != views.cameras[0].width_px || pair->left.rows != views.cameras[0].height_px) {
      throw InputError(log.string() + ": mixed sizes: the pictures change their size");
    }
    calib::View view{fmt::format("{}", message.utime), {detector.detect(pair->left), detector.detect(pair->right)}};
    if (view.cameras[0].empty() && view.cameras[1].empty()) continue;
    const double least_px = kLeastMove * views.cameras[0].width_px;
    const bool moved =
        views.views.empty() || calib::moved_px(views.views.back().cameras[0], view.cameras[0]) > least_px;
    if (moved) views.views.push_back(std::move(view));
  }
  if (pairs == 0) throw InputError(log.string() + ": has no STEREO_IMAGES");
  thin_out(views.views, most);
  return views;
}

}  // namespace arpent::tools
