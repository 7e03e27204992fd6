// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <arpent/body_pose_t.hpp>
#include <arpent/map_status_t.hpp>
#include <arpent/pose_t.hpp>
#include <arpent/wheel_state_t.hpp>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/crc32c.h"
#include "common/error.h"
#include "perception/fusion/wire.h"
#include "planning/team/wire.h"
#include "tools/mission/run.h"
#include "tools/replay/compact.h"

namespace arpent::tools {

void MissionCollector::take(Time time, const std::string& channel, BytesView bytes) {
  if (log_ != nullptr && !log_->write(time, channel, compact_for_log(channel, bytes))) refused_ = true;
  const std::int64_t utime = to_utime(time);
  result_.log_crc = crc32c_of(std::span<const std::int64_t>(&utime, 1), result_.log_crc);
  result_.log_crc = crc32c_of(bytes, result_.log_crc);
  if (channel == channels::kStereoImages) {
    ++result_.pairs;
  } else if (channel == channels::kTruthPose) {
    decode<pose_t>(bytes, [&](const pose_t& m) {
      const double* q = m.orientation_wxyz;
      const auto T = make_pose(Eigen::Map<const Eigen::Vector3d>(m.position_m), {q[0], q[1], q[2], q[3]});
      if (T) result_.truth.push_back({from_utime(m.utime), *T});
    });
  } else if (channel == channels::kPose) {
    decode<body_pose_t>(bytes, [&](const body_pose_t& m) {
      const auto pose = fusion::from_wire(m);
      if (pose && pose->frame == fusion::Frame::kWorld) result_.estimate.push_back({pose->stamp, pose->T_frame_body});
    });
  } else if (channel == channels::kPath) {
    decode<path_t>(bytes, [&](const path_t& m) {
      if (const auto path = control::from_wire(m)) result_.paths.push_back(*path);
    });
  } else if (channel == channels::kWheelState) {
    decode<wheel_state_t>(bytes, [&](const wheel_state_t& m) {
      result_.commands.push_back({from_utime(m.utime), {m.commanded_speed_mps, m.commanded_turn_rate_radps}});
    });
  } else if (channel == channels::kMapStatus) {
    decode<map_status_t>(bytes, [&](const map_status_t& m) {
      if (const auto status = mapping::from_wire(m)) result_.map = *status;
    });
  } else if (channel == channels::kMissionState) {
    decode<mission_state_t>(bytes, [&](const mission_state_t& m) {
      if (const auto report = planning::from_wire(m)) result_.reports.push_back(*report);
    });
  } else if (channel == channels::kTeamTour) {
    decode<tour_t>(bytes, [&](const tour_t& m) {
      if (const auto tour = planning::from_wire(m))
        result_.allotments.push_back({time, tour->robot, tour->viewpoints.size()});
    });
  } else if (channel == channels::kEstop) {
    ++result_.estops;
  }
}

std::string close_log(LogWriter& log) {
  try {
    log.close();
  } catch (const InputError& fault) {
    return fault.what();
  }
  return "";
}

void MissionCollector::close() {
  result_.log_fault = close_log(*log_);
}

}  // namespace arpent::tools
