// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <arpent/config_t.hpp>
#include <arpent/pose_t.hpp>
#include <arpent/stereo_images_t.hpp>
#include <fstream>

#include "common/atomic_file.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/error.h"
#include "common/log/event_log.h"
#include "perception/stereo/rectifier.h"
#include "tools/replay/replay.h"

namespace arpent::tools {
namespace {

std::optional<evaluation::StampedPose> read_truth(BytesView data) {
  pose_t message;
  std::string fault;
  if (!decode_guarded(data, message, fault)) return std::nullopt;
  const double* q = message.orientation_wxyz;
  const auto pose = make_pose(Eigen::Map<const Eigen::Vector3d>(message.position_m), {q[0], q[1], q[2], q[3]});
  if (!pose || message.child_frame != "body") return std::nullopt;
  return evaluation::StampedPose{from_utime(message.utime), *pose};
}

/// What the log says about itself.
struct Contents {
  std::map<std::string, std::string> configs;
  std::vector<Time> pairs;
  evaluation::Trajectory truth;
  std::int64_t unreadable = 0;
  bool drive = false;
  std::optional<Time> begin;
};

Contents scan(LogReader& reader) {
  Contents contents;
  while (const auto event = reader.next()) {
    std::string fault;
    if (event->channel != channels::kConfig && !contents.begin) contents.begin = event->time;
    if (event->channel == channels::kStereoImages) {
      contents.pairs.push_back(event->time);
    } else if (event->channel == channels::kWheelState) {
      contents.drive = true;
    } else if (event->channel == channels::kTruthPose) {
      if (const auto pose = read_truth(event->data)) contents.truth.push_back(*pose);
    } else if (event->channel == channels::kConfig) {
      config_t config;
      if (decode_guarded(event->data, config, fault))
        contents.configs[config.name] = config.yaml;
      else
        ++contents.unreadable;
    }
  }
  return contents;
}

/// Before reading, so that the log need not name it; and after, whatever it names.
void use_rig(ReplayInput& input) {
  ReplayConfig& config = input.config;
  config.depth.rig = config.odometry.rig = config.tags.rig = config.mapping.rig = input.rig_file;
}

}  // namespace

ReplayInput open_log(const std::filesystem::path& log, const std::filesystem::path& work_folder,
                     const std::filesystem::path& rig, const std::vector<std::string>& settings) {
  LogReader reader(log);
  Contents contents = scan(reader);
  if (contents.pairs.empty()) {
    throw InputError(fmt::format("{}: has no event on {}; `./arpent log info` shows what is in it", log.string(),
                                 channels::kStereoImages));
  }
  ReplayInput input;
  input.log = log;
  input.pairs = std::move(contents.pairs);
  input.truth = std::move(contents.truth);
  input.rig_file = rig;
  if (rig.empty()) {
    if (!contents.configs.contains("rig")) {
      throw InputError(log.string() + ": brings no rig along; give one with --rig FILE (see config/rigs)");
    }
    std::filesystem::create_directories(work_folder);
    input.rig_file = std::filesystem::absolute(work_folder / "rig.yaml");
    atomic_write(input.rig_file, contents.configs["rig"]);
  }
  (void)load_rig(input.rig_file);
  input.drive = contents.drive;
  input.begin = contents.begin.value_or(input.pairs.front());
  use_rig(input);
  config::read(input.config,
               {.text = contents.configs["replay"], .text_name = log.string() + " (replay)", .settings = settings});
  use_rig(input);
  const LogDamage& damage = reader.damage();
  if (damage.places > 0) {
    input.warnings.push_back(fmt::format("the log is damaged in {} places: {} bytes passed over, {} events missing",
                                         damage.places, damage.bytes, damage.missing));
  }
  return input;
}

evaluation::Trajectory truth_of(const ReplayInput& input, const std::string& frame) {
  const Pose T_body_cam = load_rig(input.rig_file).calibration.T_body_left;
  evaluation::Trajectory truth;
  for (const auto& [stamp, T] : input.truth)
    truth.push_back({stamp, frame == "cam0" ? Pose(T_body_cam.inverse() * T * T_body_cam) : T});
  return truth;
}

evaluation::Trajectory trajectory_of(const ReplayResult& result, const ReplayInput& input, const std::string& frame) {
  // odom is the body at the first pair, so that the left camera in its own first frame is T_bc^-1 T_odom_body T_bc.
  const Pose T_body_cam = load_rig(input.rig_file).calibration.T_body_left;
  evaluation::Trajectory trajectory;
  for (const auto& o : result.odometry) {
    const Pose& T = o.T_odom_body;
    trajectory.push_back({o.stamp, frame == "cam0" ? Pose(T_body_cam.inverse() * T * T_body_cam) : T});
  }
  return trajectory;
}

}  // namespace arpent::tools
