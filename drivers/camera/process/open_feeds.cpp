// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/process/open_feeds.h"

#include <fmt/format.h>

#include "common/error.h"
#include "drivers/camera/v4l2_source.h"

namespace arpent {
namespace {

using namespace camera;

void check(const CameraConfig& config) {
  std::vector<std::string> faults;
  const bool one_device = config.layout == "side_by_side";
  if (one_device && config.source != "v4l2") faults.emplace_back("layout = side_by_side, must go with source = v4l2");
  if (config.source != "folder") {
    if (config.left_device.empty()) faults.emplace_back("left_device, must be given");
    if (!one_device && config.right_device.empty()) faults.emplace_back("right_device, must be given");
    if (!one_device && !config.left_device.empty() && config.left_device == config.right_device) {
      faults.push_back("right_device = " + config.right_device + ", must be another than left_device");
    }
  }
  if (config.source == "aravis" && config.exposure.mode == "device") {
    faults.emplace_back(
        "exposure.mode = device, must be auto or fixed with source = aravis: two cameras that expose by "
        "themselves drift apart");
  }
  if (config.source == "v4l2" && config.exposure.mode == "auto" && config.exposure.max_gain_db > 0) {
    faults.emplace_back("exposure.max_gain_db, must be 0 with source = v4l2: its gains have no unit");
  }
  for (std::string& fault : faults) fault = "camera_process: " + fault;
  if (!faults.empty()) throw InputError(fmt::format("{}", fmt::join(faults, "\n")));
}

std::unique_ptr<Feed> open_aravis_feed(const CameraConfig& config, const AravisDevice& device, const HostTime& host) {
  const ImageFormat format{config.width_px, config.height_px, config.rate_hz};
  const ExposureSetting exposure{config.exposure.exposure_us, config.exposure.gain_db};
  const auto open = [device, params = config.aravis, format, exposure, host] {
    return open_aravis(device, params, format, exposure, host);
  };
  return std::make_unique<ThreadedFeed>(open, config.connection);
}

std::unique_ptr<Feed> open_v4l2_feed(const CameraConfig& config, const std::string& device, const HostTime& host) {
  V4l2Params params;
  params.device = device;
  params.width_px = config.layout == "side_by_side" ? 2 * config.width_px : config.width_px;
  params.height_px = config.height_px;
  params.rate_hz = config.rate_hz;
  params.control_exposure = config.exposure.mode != "device";
  params.exposure = {config.exposure.exposure_us, 0};
  params.transfer = from_seconds(config.pairing.transfer_s);
  return std::make_unique<ThreadedFeed>([params, host] { return open_v4l2(params, host); }, config.connection);
}

}  // namespace

std::vector<std::unique_ptr<Feed>> open_feeds(const CameraConfig& config, Clock& clock) {
  check(config);
  std::vector<std::unique_ptr<Feed>> feeds;
  if (config.source == "folder") {
    auto [left, right] = open_folder(config.folder, [&clock] { return clock.now(); });
    feeds.push_back(std::make_unique<DirectFeed>(std::move(left)));
    feeds.push_back(std::make_unique<DirectFeed>(std::move(right)));
    return feeds;
  }
  const HostTime host(clock.now());
  if (config.source == "aravis") {
    feeds.push_back(open_aravis_feed(config, {config.left_device, config.left_features}, host));
    feeds.push_back(open_aravis_feed(config, {config.right_device, config.right_features}, host));
    return feeds;
  }
  feeds.push_back(open_v4l2_feed(config, config.left_device, host));
  if (config.layout == "two_devices") feeds.push_back(open_v4l2_feed(config, config.right_device, host));
  return feeds;
}

}  // namespace arpent
