// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The frozen wire: a changed field, type or dimension of a message changes its fingerprint, and mixed versions stop
// understanding each other.
#include <gtest/gtest.h>

#include <arpent/config_t.hpp>
#include <arpent/counter_t.hpp>
#include <arpent/depth_t.hpp>
#include <arpent/disparity_t.hpp>
#include <arpent/health_t.hpp>
#include <arpent/image_t.hpp>
#include <arpent/map_status_t.hpp>
#include <arpent/odometry_t.hpp>
#include <arpent/pose_t.hpp>
#include <arpent/stereo_images_t.hpp>
#include <cstdint>
#include <map>
#include <string>

#include "common/wire_schema.h"

namespace arpent {
namespace {

const std::map<std::string, std::uint64_t> kFrozen = {
    {"config_t", 0xc022bb0724385ef0},        {"counter_t", 0x85bfc43c0b3c07d0},  {"depth_t", 0x46661bd4b0c331b9},
    {"disparity_t", 0xaefdcc67a47cea87},     {"health_t", 0xffb94ded487d204b},   {"image_t", 0x91ed4266ae1b2afb},
    {"map_status_t", 0xe41e8203cf2d3d8c},    {"odometry_t", 0x41b22990722cc4f3}, {"pose_t", 0x8f5fa53992c3e10f},
    {"stereo_images_t", 0xa5eee5aa87218c9c},
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
  expect_same<stereo_images_t>();
}

}  // namespace
}  // namespace arpent
