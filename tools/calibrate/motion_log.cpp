// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/motion_log.h"

#include <fmt/format.h>

#include <arpent/config_t.hpp>
#include <optional>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/log/event_log.h"
#include "perception/stereo/rectifier.h"
#include "perception/tags/observer.h"
#include "tools/replay/replay.h"

namespace arpent::tools {
namespace {

/// The message as its room's type; nullopt if it is damaged or says nonsense.
template <class Message, class Value>
std::optional<Value> take(const LogEvent& event, Result<Value> (*read)(const Message&)) {
  Message message;
  std::string fault;
  if (!decode_guarded(event.data, message, fault)) return std::nullopt;
  const auto value = read(message);
  return value ? std::optional(*value) : std::nullopt;
}

/// Whether `stamp` is news after the last one. Throws InputError if it lies before it.
template <class List, class StampOf>
bool is_new(const List& list, Time stamp, const StampOf& stamp_of, const std::string& what) {
  if (list.empty() || stamp > stamp_of(list.back())) return true;
  if (stamp == stamp_of(list.back())) return false;
  throw InputError(fmt::format("{}: time goes back by {:.3f} s: one robot and one run per log", what,
                               to_seconds(stamp_of(list.back()) - stamp)));
}

template <class List, class Item>
void append(List& list, const std::optional<Item>& item, const std::string& what) {
  if (item && is_new(
                  list, item->stamp, [](const auto& i) { return i.stamp; }, what))
    list.push_back(*item);
}

void take_config(const LogEvent& event, MotionLog& log) {
  config_t message;
  std::string fault;
  if (decode_guarded(event.data, message, fault)) log.configs[message.name] = message.yaml;
}

void take_wheels(const LogEvent& event, MotionLog& log) {
  const auto state = take<wheel_state_t, base::WheelState>(event, base::from_wire);
  if (state && state->status.heard && to_utime(state->status.stamp) > 0) {
    append(log.wheels, std::optional(state->status), "WHEEL_STATE");
  }
}

void take_tags(const LogEvent& event, MotionLog& log) {
  const auto observation = take<tag_observation_t, tags::BodyObservation>(event, tags::from_wire);
  if (observation && observation->accepted) append(log.tags, observation, "TAG_OBSERVATION");
}

void take_event(const LogEvent& event, MotionLog& log) {
  const auto is = [&](const char* name) { return is_channel(event.channel, name); };
  if (is(channels::kConfig)) take_config(event, log);
  if (is(channels::kWheelState)) take_wheels(event, log);
  if (is(channels::kTagObservation)) take_tags(event, log);
  if (is(channels::kOdometry))
    append(log.odometry, take<odometry_t, odometry::BodyOdometry>(event, odometry::from_wire), "ODOMETRY");
  if (is(channels::kImu)) append(log.imu, take<imu_t, imu::Reading>(event, imu::from_wire), "IMU");
  if (is(channels::kStereoImages)) ++log.pairs;
}

const std::string& config_of(const MotionLog& log, const char* name, const char* option) {
  const auto found = log.configs.find(name);
  if (found != log.configs.end()) return found->second;
  throw InputError(
      fmt::format("{}: brings no {} along (CONFIG): name its file with {}", log.file.string(), name, option));
}

}  // namespace

bool is_channel(const std::string& channel, const char* name) {
  return channel == name || channel.ends_with(std::string("/") + name);
}

MotionLog read_motion_log(const std::filesystem::path& file, const Progress& progress) {
  MotionLog log;
  log.file = file;
  LogReader reader(file);
  while (const auto event = reader.next()) {
    take_event(*event, log);
    progress(reader.position_bytes(), reader.size_bytes());
  }
  return log;
}

RigConfig rig_of(const MotionLog& log, const std::filesystem::path& file) {
  if (!file.empty()) return load_rig(file).config;
  return config::load_text<RigConfig>(log.file.string() + " (rig)", config_of(log, "rig", "--rig"));
}

RobotConfig robot_of(const MotionLog& log, const std::filesystem::path& file) {
  if (!file.empty()) return config::load<RobotConfig>(file);
  return config::load_text<RobotConfig>(log.file.string() + " (robot)", config_of(log, "robot", "--robot"));
}

TagConfig tag_config_of(const MotionLog& log, const std::filesystem::path& file) {
  if (!file.empty()) return config::load<TagConfig>(file);
  ReplayConfig replay;
  replay.depth.rig = replay.odometry.rig = replay.tags.rig = replay.mapping.rig = "-";
  config::read(replay, {.text = config_of(log, "replay", "--tags"), .text_name = log.file.string() + " (replay)"});
  return replay.tags;
}

void for_each_pair(const MotionLog& log, const StereoCalibration& rig, const Progress& progress,
                   const std::function<void(const stereo::StereoPair&)>& use) {
  LogReader reader(log.file);
  while (const auto event = reader.next()) {
    progress(reader.position_bytes(), reader.size_bytes());
    if (!is_channel(event->channel, channels::kStereoImages)) continue;
    const auto pair = take<stereo_images_t, stereo::StereoPair>(*event, stereo::from_wire);
    if (!pair) continue;
    const PinholeCamera& camera = rig.left.pinhole;
    if (pair->left.cols != camera.width_px || pair->left.rows != camera.height_px) {
      throw InputError(fmt::format("{}: the pictures are {} x {} px, the rig's {} x {}", log.file.string(),
                                   pair->left.cols, pair->left.rows, camera.width_px, camera.height_px));
    }
    use(*pair);
  }
}

std::vector<odometry::BodyOdometry> odometry_from_images(const MotionLog& log, const StereoCalibration& rig,
                                                         const Progress& progress) {
  const stereo::Rectifier rectifier(rig);
  odometry::StereoOdometry odometry(rectifier.stereo(), {});
  std::vector<odometry::BodyOdometry> list;
  for_each_pair(log, rig, progress, [&](const stereo::StereoPair& pair) {
    const auto [left, right] = rectifier.rectify(pair.left, pair.right);
    list.push_back(odometry::to_body(odometry.track(pair.stamp, left, right), pair.sequence,
                                     rectifier.T_body_rectified(), list.empty() ? nullptr : &list.back()));
  });
  return list;
}

std::vector<tags::BodyObservation> tags_from_images(const MotionLog& log, const StereoCalibration& rig,
                                                    const TagConfig& config, const Progress& progress) {
  const stereo::Rectifier rectifier(rig);
  const tags::TagObserver observer(config.cube, config.detector, config.ground, rectifier.stereo(),
                                   rectifier.T_body_rectified());
  std::vector<tags::BodyObservation> list;
  for_each_pair(log, rig, progress, [&](const stereo::StereoPair& pair) {
    const auto [left, right] = rectifier.rectify(pair.left, pair.right);
    const tags::Observation seen = observer.observe(left, right);
    if (!seen.accepted()) return;
    tags::BodyObservation observation = tags::to_body(pair.stamp, pair.sequence, seen);
    observation.T_world_body = seen.measured.T_world_body;
    observation.covariance = seen.measured.covariance;
    list.push_back(observation);
  });
  return list;
}

}  // namespace arpent::tools
