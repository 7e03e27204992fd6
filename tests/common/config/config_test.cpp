// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/config/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "common/config/rig.h"
#include "common/config/robot.h"
#include "common/error.h"

namespace arpent {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct Inner {
  double edge_m = 0.1;
  std::vector<double> list{1, 2};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("edge_m", self.edge_m, "an edge", config::greater_than(0.0));
    visitor.field("list", self.list, "numbers");
  }
  bool operator==(const Inner&) const = default;
};

struct Outer {
  int count = 3;
  bool flag = true;
  std::string mode = "fast";
  Inner inner = {};
  std::filesystem::path file = "/x";

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("count", self.count, "a count", config::between(0, 10));
    visitor.field("flag", self.flag, "a flag");
    visitor.field("mode", self.mode, "a mode", config::one_of({"fast", "exact", "odd \"one\""}));
    visitor.group("inner", self.inner, "a group");
    visitor.field("file", self.file, "a file", config::required_path());
  }
  bool operator==(const Outer&) const = default;
};

std::string fault_of(const std::string& text) {
  try {
    (void)config::load_text<Outer>("c.yaml", text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Config, WhatIsNotGivenKeepsItsDefault) {
  EXPECT_EQ(config::load_text<Outer>("c", "count: 7"), (Outer{.count = 7}));
  EXPECT_EQ(config::load_text<Outer>("c", "# nothing\n"), Outer{});
}

TEST(Config, EveryFaultIsListedWithItsLine) {
  EXPECT_THAT(
      fault_of("count: many\ninner:\n  edge: 2\n  list: [1, x]\nspeed: 3\nflag: 1.5\n"),
      AllOf(HasSubstr("c.yaml:1: count = many, must be a whole number"),
            HasSubstr("c.yaml:3: unknown key inner.edge, did you mean inner.edge_m?"),
            HasSubstr("c.yaml:4: inner.list = a list, must be a list of numbers"),
            HasSubstr("c.yaml:5: unknown key speed"), HasSubstr("c.yaml:6: flag = 1.5, must be true or false")));
}

TEST(Config, EveryBrokenRuleIsListedWithItsLine) {
  EXPECT_THAT(fault_of("count: 11\ninner: {edge_m: -1}\nmode: slow"),
              AllOf(HasSubstr("c.yaml:1: count = 11, must be between 0 and 10"),
                    HasSubstr("c.yaml:2: inner.edge_m = -1.0, must be > 0"),
                    HasSubstr("c.yaml:3: mode = \"slow\", must be one of fast, exact")));
}

TEST(Config, NumbersThatAreNotFiniteAreRefused) {
  EXPECT_THAT(fault_of("inner: {edge_m: .nan}"), HasSubstr("must be a finite number"));
  EXPECT_THAT(fault_of("inner: {edge_m: .inf}"), HasSubstr("must be a finite number"));
}

TEST(Config, AKeyGivenTwiceIsAFault) {
  EXPECT_THAT(fault_of("count: 1\ncount: 2"), HasSubstr("given twice"));
}

TEST(Config, WhatIsNoYamlIsAFaultWithItsLine) {
  EXPECT_THAT(fault_of("count: 1\nflag: [true\n"), HasSubstr("not valid YAML"));
  EXPECT_THAT(fault_of("- 1\n- 2\n"), HasSubstr("must be a list of `key: value` lines"));
  EXPECT_THAT(fault_of("inner: 5"), HasSubstr("must be a group"));
}

TEST(Config, WhatIsRequiredMustBeGiven) {
  EXPECT_THAT(fault_of("file: ''"), HasSubstr("must be given"));
}

TEST(Config, SettingsFromFlagsComeLastAndSayWhatIsWrongWithThem) {
  Outer outer;
  const auto origins = config::read(outer, {.text = "count: 7", .settings = {"inner.edge_m=0.5", "count=8"}});
  EXPECT_EQ(outer.inner.edge_m, 0.5);
  EXPECT_EQ(outer.count, 8);
  EXPECT_EQ(origins.at("count"), "flag");
  EXPECT_THROW(config::read(outer, {.settings = {"nonsense"}}), InputError);
  EXPECT_THROW(config::read(outer, {.settings = {"inner.edge_m=-1"}}), InputError);
}

TEST(Config, WhatIsPrintedLoadsBackEqual) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(1e-9, 1e6);
  for (int i = 0; i < 200; ++i) {
    Outer outer;
    outer.count = static_cast<int>(generator() % 11);
    outer.flag = generator() % 2 == 0;
    outer.mode = generator() % 2 == 0 ? "exact" : "odd \"one\"";
    outer.inner.edge_m = uniform(generator);
    outer.inner.list.assign(generator() % 5, uniform(generator));
    outer.file = "/a b/#" + std::to_string(i);
    EXPECT_EQ(config::load_text<Outer>("c", config::to_yaml(outer)), outer) << config::to_yaml(outer);
  }
}

TEST(Config, PathsAreRelativeToTheFileTheyStandIn) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "config_paths";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "c.yaml") << "file: ../there.yaml\n";
  EXPECT_EQ(config::load<Outer>(folder / "c.yaml").file, (folder / "../there.yaml").lexically_normal());
}

TEST(Config, AFileThatIsNotThereIsOneClearError) {
  EXPECT_THROW((void)config::load<Outer>("/no/such/file.yaml"), InputError);
  EXPECT_THROW((void)config::load<Outer>("/tmp"), InputError);
}

TEST(Config, ChangingAnyByteOfAConfigNeverCrashes) {
  const std::string good = config::to_yaml(Outer{});
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const char c : {'\0', ':', '[', '{', '"', '\n', '-', '\xff'}) {
      std::string bad = good;
      bad[at] = c;
      (void)fault_of(bad);
    }
    (void)fault_of(good.substr(0, at));
  }
}

TEST(Rig, EveryShippedRigIsSound) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ARPENT_SOURCE_DIR "/config/rigs")) {
    EXPECT_NO_THROW((void)load_rig(entry.path())) << entry.path();
    ++count;
  }
  EXPECT_GT(count, 0);
}

TEST(Robot, EveryShippedRobotIsSoundAndItsRigIsThere) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ARPENT_SOURCE_DIR "/config/robots")) {
    const auto robot = config::load<RobotConfig>(entry.path());
    EXPECT_NO_THROW((void)load_rig(robot.rig)) << entry.path();
    ++count;
  }
  EXPECT_GT(count, 0);
}

TEST(Rig, SurvivesTheRoundTripThroughItsFile) {
  StereoCalibration calibration;
  calibration.left = {
      {640, 512, 377, 378, 320.5, 255.25}, DistortionModel::kRadialTangential, {0.1, -0.2, 1e-3, 2e-4, 0.05}};
  calibration.right = {{640, 512, 376, 379, 321.5, 254.25}, DistortionModel::kEquidistant, {0.1, -0.2, 1e-3, 2e-4, 0}};
  calibration.T_right_left.linear() = so3_exp({0.01, 0.02, -0.03});
  calibration.T_right_left.translation() = Eigen::Vector3d(-0.26, 0.001, 0.002);
  calibration.T_body_left.linear() = R_body_from_camera_axes();
  calibration.T_body_left.translation() = Eigen::Vector3d(0.2, 0.13, 0.4);
  const auto rig = config::load_text<RigConfig>("rig", config::to_yaml(to_rig(calibration, "r")));
  const StereoCalibration back = to_calibration(rig, "rig");
  EXPECT_EQ(back.left.pinhole, calibration.left.pinhole);
  EXPECT_EQ(back.right.coefficients, calibration.right.coefficients);
  EXPECT_TRUE(back.T_right_left.isApprox(calibration.T_right_left, 1e-12));
  EXPECT_TRUE(back.T_body_left.isApprox(calibration.T_body_left, 1e-12));
}

TEST(Rig, AnUnusableCalibrationListsItsFaults) {
  RigConfig rig = config::load<RigConfig>(ARPENT_SOURCE_DIR "/config/rigs/wifibot_stereo.yaml");
  rig.T_right_left.translation_m[0] = 0.26;
  rig.T_body_cam.quaternion_wxyz = {2, 0, 0, 0};
  try {
    (void)to_calibration(rig, "rig");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("unit quaternion"));
  }
  rig.T_body_cam.quaternion_wxyz = {1, 0, 0, 0};
  EXPECT_THROW((void)to_calibration(rig, "rig"), InputError) << "swapped baseline";
}

}  // namespace
}  // namespace arpent
