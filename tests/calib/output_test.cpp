// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/output.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/error.h"
#include "perception/stereo/calibration_file.h"
#include "tests/calib/simulated_views.h"

namespace arpent::calib {
namespace {

StereoCalibration read_back(const std::string& text) {
  const auto file = std::filesystem::temp_directory_path() / ("output_test_" + std::to_string(getpid()) + ".yaml");
  std::ofstream(file) << text;
  const StereoCalibration calibration = stereo::read_calibration(file, 0, 0);
  std::filesystem::remove(file);
  return calibration;
}

void expect_same(const StereoCalibration& read, const RigEstimate& rig) {
  for (const auto& [a, b] : {std::pair(read.left, rig.cameras[0]), std::pair(read.right, rig.cameras[1])}) {
    EXPECT_EQ(a.pinhole, b.pinhole);
    EXPECT_EQ(a.distortion, b.distortion);
    EXPECT_EQ(a.coefficients, b.coefficients);
  }
  EXPECT_LT((read.T_right_left.matrix() - rig.T_cam_first[1].matrix()).norm(), 1e-12);
}

TEST(CalibOutput, TheStackReadsKalibrsCamchainBackUnchanged) {
  for (const auto model : {DistortionModel::kRadialTangential, DistortionModel::kEquidistant}) {
    const RigEstimate rig = simulated_rig(model);
    expect_same(read_back(to_camchain_yaml(rig)), rig);
  }
}

StereoCalibration stereo_of(const RigEstimate& rig) {
  StereoCalibration stereo;
  stereo.left = rig.cameras[0];
  stereo.right = rig.cameras[1];
  stereo.T_right_left = rig.T_cam_first[1];
  return stereo;
}

TEST(CalibOutput, TheStackReadsOpencvsYamlBackUnchangedWithEitherLens) {
  for (const auto model : {DistortionModel::kRadialTangential, DistortionModel::kEquidistant}) {
    const RigEstimate rig = simulated_rig(model);
    expect_same(read_back(to_opencv_yaml(stereo_of(rig))), rig);
  }
  EXPECT_THROW((void)read_back("%YAML:1.0\n---\nimage_width: 9\nimage_height: 9\ndistortion_model: fov\n"), InputError);
}

TEST(CalibOutput, OurRigFileKeepsWhatACalibrationOfTheCamerasDoesNotKnow) {
  RigConfig before;
  before.name = "mine";
  before.T_body_cam.translation_m = {0.2, 0.1, 0.4};
  before.rate_hz = 7;
  const RigConfig after = to_rig_config(stereo_of(simulated_rig(DistortionModel::kEquidistant)), before);
  EXPECT_EQ(after.name, "mine");
  EXPECT_EQ(after.T_body_cam.translation_m, before.T_body_cam.translation_m);
  EXPECT_EQ(after.rate_hz, 7);
  EXPECT_EQ(after.left.fx_px, 760);
  EXPECT_EQ(after.left.distortion, "equidistant");
  EXPECT_NEAR(after.T_right_left.translation_m[0], -0.26, 1e-12);
}

TEST(CalibOutput, KalibrsNumbersAlwaysHaveADecimalPoint) {
  RigEstimate rig = simulated_rig(DistortionModel::kRadialTangential);
  const std::string yaml = to_camchain_yaml(rig);
  EXPECT_NE(yaml.find("intrinsics: [760.0, 762.0, 645.0, 505.0]"), std::string::npos) << yaml;
}

}  // namespace
}  // namespace arpent::calib
