// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// camera_process: two cameras in, STEREO_IMAGES out. It never waits for a camera: devices live in threads of their own
// (feed.h) and are asked a few hundred times a second what they have. A missing, silent or frozen camera is a health
// error, and the process goes on looking for it.
#pragma once

#include <memory>
#include <string>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "drivers/camera/aravis_source.h"
#include "drivers/camera/exposure_controller.h"
#include "drivers/camera/feed.h"
#include "drivers/camera/folder_source.h"
#include "drivers/camera/pairer.h"

namespace arpent {

struct CameraConfig {
  std::string source = "aravis";
  std::string layout = "two_devices";
  std::string left_device;
  std::string right_device;
  std::string left_features;
  std::string right_features;
  int width_px = 640;
  int height_px = 512;
  double rate_hz = 5;
  camera::FolderParams folder;
  camera::AravisParams aravis;
  camera::PairerParams pairing;
  camera::ExposureParams exposure;
  camera::FeedParams connection;
  int poll_us = 4000;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("source", self.source, "aravis: GenICam cameras; v4l2: cameras of the kernel; folder: image files",
                  config::one_of({"aravis", "v4l2", "folder"}));
    visitor.field("layout", self.layout, "side_by_side: one V4L2 device whose frames hold both images",
                  config::one_of({"two_devices", "side_by_side"}));
    visitor.field("left_device", self.left_device,
                  "aravis: name, serial or IPv4 address (./arpent camera list); v4l2: /dev/video…");
    visitor.field("right_device", self.right_device, "the same of the right camera");
    visitor.field("left_features", self.left_features,
                  "GenICam features set at the start, e.g. LineSelector=Line1 LineMode=Output");
    visitor.field("right_features", self.right_features, "the same of the right camera");
    visitor.field("width_px", self.width_px, "of one image; must be the rig's", config::between(16, 16384));
    visitor.field("height_px", self.height_px, "of one image; must be the rig's", config::between(16, 16384));
    visitor.field("rate_hz", self.rate_hz, "pairs per second if the cameras run freely", config::between(0.1, 1000.0));
    visitor.group("folder", self.folder, "image files");
    visitor.group("aravis", self.aravis, "GenICam cameras");
    visitor.group("pairing", self.pairing, "pairs from frames");
    visitor.group("exposure", self.exposure, "one exposure for both cameras");
    visitor.group("connection", self.connection, "lost cameras");
    visitor.field("poll_us", self.poll_us, "time between two looks at the cameras", config::between(500, 1000000));
  }
};

class CameraProcess {
 public:
  using Config = CameraConfig;
  static constexpr char kName[] = "camera_process";
  static constexpr char kHelp[] = "Publishes stereo pairs from two cameras or from image files.";

  /// Throws InputError for a configuration that can never work. A camera that is not there is no error.
  CameraProcess(const Config& config, Bus& bus, Clock& clock);
  ~CameraProcess();

  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
