// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The frozen wire: a changed field, type or dimension of a message changes its fingerprint, and mixed versions stop
// understanding each other.
#include <gtest/gtest.h>

#include <arpent/base_request_t.hpp>
#include <arpent/body_pose_t.hpp>
#include <arpent/can_frame_t.hpp>
#include <arpent/can_frames_t.hpp>
#include <arpent/config_t.hpp>
#include <arpent/counter_t.hpp>
#include <arpent/depth_t.hpp>
#include <arpent/disparity_t.hpp>
#include <arpent/estop_t.hpp>
#include <arpent/frame_alignment_t.hpp>
#include <arpent/health_t.hpp>
#include <arpent/image_t.hpp>
#include <arpent/imu_t.hpp>
#include <arpent/map_patch_t.hpp>
#include <arpent/map_status_t.hpp>
#include <arpent/mission_command_t.hpp>
#include <arpent/mission_state_t.hpp>
#include <arpent/odometry_t.hpp>
#include <arpent/path_t.hpp>
#include <arpent/pose_t.hpp>
#include <arpent/robot_state_t.hpp>
#include <arpent/stereo_images_t.hpp>
#include <arpent/tag_observation_t.hpp>
#include <arpent/tag_t.hpp>
#include <arpent/tour_report_t.hpp>
#include <arpent/tour_t.hpp>
#include <arpent/tracker_status_t.hpp>
#include <arpent/viewpoint_t.hpp>
#include <arpent/wheel_command_t.hpp>
#include <arpent/wheel_state_t.hpp>
#include <cstdint>
#include <map>
#include <string>

#include "common/wire_schema.h"

namespace arpent {
namespace {

const std::map<std::string, std::uint64_t> kFrozen = {
    {"config_t", 0xc022bb0724385ef0},
    {"counter_t", 0x85bfc43c0b3c07d0},
    {"depth_t", 0x46661bd4b0c331b9},
    {"disparity_t", 0xaefdcc67a47cea87},
    {"health_t", 0xffb94ded487d204b},
    {"image_t", 0x91ed4266ae1b2afb},
    {"map_status_t", 0xe41e8203cf2d3d8c},
    {"odometry_t", 0x41b22990722cc4f3},
    {"pose_t", 0x8f5fa53992c3e10f},
    {"stereo_images_t", 0xa5eee5aa87218c9c},
    {"base_request_t", 0x28405353a18c39d2},
    {"body_pose_t", 0x57db1caa8d81184a},
    {"can_frame_t", 0x9ef0c2b38295729b},
    {"can_frames_t", 0x16fbef533c8b5605},
    {"estop_t", 0xaa40007b42cd97a5},
    {"frame_alignment_t", 0xf2133b5005ebec60},
    {"imu_t", 0x9db5bd7ce17f5232},
    {"mission_command_t", 0x688434df5aa88fdc},
    {"mission_state_t", 0x6e50eaf98d148b1a},
    {"path_t", 0xf387aa8be2ac05b2},
    {"tag_observation_t", 0x2068e4feeadbb5c4},
    {"tag_t", 0x90538cba87c4df6d},
    {"tracker_status_t", 0x7edc1a0be15f7ba4},
    {"wheel_command_t", 0x8bd3bb1dcd9c52b5},
    {"wheel_state_t", 0xcc8b838b92a06502},
    {"map_patch_t", 0xe8f38b89fe08d1aa},
    {"robot_state_t", 0x0e566938f896bc3c},
    {"tour_report_t", 0xb76ca3069dd18e21},
    {"tour_t", 0x4a5176a40f00c244},
    {"viewpoint_t", 0x3abacb40aa61490d},
};

TEST(Fingerprints, AreThoseOfTheFrozenTable) {
  std::map<std::string, std::uint64_t> now;
  for (const std::string& name : wire_schema().type_names()) now[name] = wire_schema().fingerprint(name);
  for (const auto& [name, fingerprint] : now) {
    const auto frozen = kFrozen.find(name);
    EXPECT_TRUE(frozen != kFrozen.end() && frozen->second == fingerprint)
        << name << " is now 0x" << std::hex << fingerprint
        << ": if the change of the wire is meant, put this into the table and into CHANGELOG.md";
  }
  EXPECT_EQ(now.size(), kFrozen.size()) << "a message of the table is gone";
}

template <class Message>
void expect_same() {
  EXPECT_EQ(wire_schema().fingerprint(Message::getTypeName()), static_cast<std::uint64_t>(Message::getHash()))
      << Message::getTypeName();
}

TEST(Fingerprints, EqualThoseThatLcmGenComputes) {
  expect_same<config_t>();
  expect_same<counter_t>();
  expect_same<depth_t>();
  expect_same<disparity_t>();
  expect_same<health_t>();
  expect_same<image_t>();
  expect_same<map_status_t>();
  expect_same<odometry_t>();
  expect_same<pose_t>();
  expect_same<base_request_t>();
  expect_same<body_pose_t>();
  expect_same<can_frame_t>();
  expect_same<can_frames_t>();
  expect_same<estop_t>();
  expect_same<frame_alignment_t>();
  expect_same<imu_t>();
  expect_same<mission_command_t>();
  expect_same<mission_state_t>();
  expect_same<path_t>();
  expect_same<tag_observation_t>();
  expect_same<tag_t>();
  expect_same<tracker_status_t>();
  expect_same<wheel_command_t>();
  expect_same<wheel_state_t>();
  expect_same<stereo_images_t>();
  expect_same<map_patch_t>();
  expect_same<robot_state_t>();
  expect_same<tour_report_t>();
  expect_same<tour_t>();
  expect_same<viewpoint_t>();
}

}  // namespace
}  // namespace arpent
