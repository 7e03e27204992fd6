// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/import/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <arpent/config_t.hpp>
#include <arpent/pose_t.hpp>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "common/atomic_file.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/error.h"
#include "common/log/event_log.h"
#include "perception/stereo/wire.h"
#include "sim/sequence.h"
#include "tools/progress.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;

config_t make_config(Time stamp, const std::string& name, const std::string& yaml) {
  config_t message;
  message.utime = to_utime(stamp);
  message.name = name;
  message.yaml = yaml;
  return message;
}

pose_t make_pose_message(const TruePose& pose) {
  pose_t message{};
  message.utime = to_utime(pose.stamp);
  message.frame = "world";
  message.child_frame = "body";
  const Eigen::Quaterniond q = canonical_quaternion(pose.T_world_body.linear());
  for (int i = 0; i < 3; ++i) message.position_m[i] = pose.T_world_body.translation()[i];
  message.orientation_wxyz[0] = q.w();
  message.orientation_wxyz[1] = q.x();
  message.orientation_wxyz[2] = q.y();
  message.orientation_wxyz[3] = q.z();
  return message;
}

std::string replay_yaml(const Dataset& dataset, const ImportProfile& profile) {
  const double Bf = dataset.calibration.T_right_left.translation().norm() * dataset.calibration.left.pinhole.fx_px;
  const int range = 16 * static_cast<int>(std::ceil((Bf / profile.min_range_m + 1) / 16));
  return fmt::format(
      "trajectory_frame: {}\n"
      "depth: {{matcher: {{max_disparity_px: {}}}, min_range_m: {}, max_range_m: {}}}\n"
      "mapping: {{tsdf: {{voxel_m: {}, min_range_m: {}, max_range_m: {}}}}}\n",
      profile.trajectory_frame, std::clamp(range, 16, 511), profile.min_range_m, profile.max_range_m, profile.voxel_m,
      profile.min_range_m, profile.max_range_m);
}

/// A log that vanishes unless it is committed.
class TemporaryLog {
 public:
  explicit TemporaryLog(const fs::path& target) : target_(target), path_(target.string() + ".part"), writer_(path_) {}
  TemporaryLog(const TemporaryLog&) = delete;
  TemporaryLog& operator=(const TemporaryLog&) = delete;
  ~TemporaryLog() {
    std::error_code ignored;
    if (!committed_) fs::remove(path_, ignored);
  }

  template <class Message>
  void write(Time time, const std::string& channel, const Message& message) {
    if (!writer_.write(time, channel, encode(message))) writer_.close();  // throws, with the reason
  }

  void commit() {
    writer_.close();
    std::error_code error;
    fs::rename(path_, target_, error);
    if (error) throw InputError("cannot write " + target_.string() + ": " + error.message());
    committed_ = true;
  }

 private:
  fs::path target_;
  fs::path path_;
  LogWriter writer_;
  bool committed_ = false;
};

ImportedPair load_pair(const DatasetFrame& frame) {
  ImportedPair pair{frame.stamp, cv::imread(frame.left.string(), cv::IMREAD_GRAYSCALE),
                    cv::imread(frame.right.string(), cv::IMREAD_GRAYSCALE)};
  if (pair.left.empty()) throw InputError(frame.left.string() + ": is no image");
  if (pair.right.empty()) throw InputError(frame.right.string() + ": is no image");
  if (pair.left.size() != pair.right.size()) {
    throw InputError(frame.right.string() + ": has another size than its left image");
  }
  return pair;
}

ImportCounts import_images(const Dataset& dataset, const ImportProfile& profile, const fs::path& log) {
  const PinholeCamera& camera = dataset.calibration.left.pinhole;
  ImportCounts counts = write_log(log, dataset, profile, dataset.frames.size(), [&](std::size_t i) {
    ImportedPair pair = load_pair(dataset.frames[i]);
    if (pair.left.cols != camera.width_px || pair.left.rows != camera.height_px) {
      throw InputError(dataset.frames[i].left.string() + ": is not of the camera's size");
    }
    return pair;
  });
  counts.unpaired = dataset.unpaired;
  return counts;
}

}  // namespace

ImportCounts write_log(const fs::path& log, const Dataset& dataset, const ImportProfile& profile, std::size_t count,
                       const std::function<ImportedPair(std::size_t)>& load) {
  RigConfig rig = to_rig(dataset.calibration, dataset.name);
  rig.min_range_m = profile.min_range_m;
  rig.max_range_m = profile.max_range_m;
  rig.rate_hz = std::clamp(dataset.rate_hz, 0.1, 1000.0);
  const std::string rig_yaml = config::to_yaml(rig);
  const fs::path rig_file = log.string() + ".rig.yaml";
  TemporaryLog out(log);
  ImportCounts counts;
  std::size_t next_truth = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const ImportedPair pair = load(i);
    if (i == 0) {
      out.write(pair.stamp, channels::kConfig, make_config(pair.stamp, "rig", rig_yaml));
      out.write(pair.stamp, channels::kConfig, make_config(pair.stamp, "replay", replay_yaml(dataset, profile)));
    }
    // Truth from before the first pair is left out, so that event times do not go back.
    while (i == 0 && next_truth < dataset.truth.size() && dataset.truth[next_truth].stamp < pair.stamp) ++next_truth;
    for (; next_truth < dataset.truth.size() && dataset.truth[next_truth].stamp <= pair.stamp; ++next_truth) {
      out.write(dataset.truth[next_truth].stamp, channels::kTruthPose, make_pose_message(dataset.truth[next_truth]));
      ++counts.poses;
    }
    const stereo::StereoPair stereo_pair{pair.stamp, static_cast<std::int64_t>(i), pair.left, pair.right};
    out.write(pair.stamp, channels::kStereoImages, stereo::to_wire(stereo_pair, true));
    show_progress("import", i + 1, count);
  }
  counts.pairs = static_cast<std::int64_t>(count);
  atomic_write(rig_file, rig_yaml);
  try {
    out.commit();
  } catch (const InputError&) {
    fs::remove(rig_file);
    throw;
  }
  return counts;
}

ImportCounts import_kitti(const fs::path& folder, const fs::path& log) {
  return import_images(read_kitti(folder), {3.0, 25.0, 0.2, "cam0"}, log);
}

ImportCounts import_euroc(const fs::path& folder, const fs::path& log) {
  return import_images(read_euroc(folder), {0.4, 8.0, 0.1, "cam0"}, log);
}

StereoCalibration wifibot_calibration() {
  StereoCalibration calibration;
  calibration.left.pinhole = {640, 512, 377, 377, 319.5, 255.5};
  calibration.right = calibration.left;
  calibration.T_right_left.translation().x() = -0.26;
  calibration.T_body_left.linear() = R_body_from_camera_axes();
  calibration.T_body_left.translation() = Eigen::Vector3d(0.20, 0.13, 0.40);
  return calibration;
}

ImportCounts import_rendered(double duration_s, const fs::path& log) {
  Dataset dataset;
  dataset.name = "rendered_arena";
  dataset.rate_hz = 5;
  dataset.calibration = wifibot_calibration();
  const RectifiedStereo stereo{dataset.calibration.left.pinhole, 0.26};
  const sim::Scene scene = sim::make_test_arena();
  const auto drive = sim::make_arena_drive(duration_s, dataset.rate_hz, kDatasetEpoch);
  for (const auto& pose : drive) dataset.truth.push_back({pose.stamp, pose.T_world_body});
  return write_log(log, dataset, {0.3, 5.0, 0.1, "body"}, drive.size(), [&](std::size_t i) {
    const auto pair = sim::render_pair(scene, stereo, dataset.calibration.T_body_left, drive[i], i);
    return ImportedPair{drive[i].stamp, pair.left, pair.right};
  });
}

}  // namespace arpent::tools
