// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/datasets/dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "common/error.h"
#include "common/log/event_log.h"
#include "tools/import/import.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kP = " 50 0 16 0 0 50 12 0 0 0 1 0\n";
constexpr const char* kP1 = " 50 0 16 -25 0 50 12 0 0 0 1 0\n";

class DatasetTest : public testing::Test {
 protected:
  DatasetTest() {
    fs::remove_all(folder_);
    for (const char* camera : {"image_0", "image_1"}) {
      fs::create_directories(folder_ / camera);
      for (int i = 0; i < 3; ++i) {
        cv::imwrite((folder_ / camera / ("00000" + std::to_string(i) + ".png")).string(),
                    cv::Mat1b(24, 32, static_cast<std::uint8_t>(10 * i + 5)));
      }
    }
    put("calib.txt", std::string("P0:") + kP + "P1:" + kP1 + "P2:" + kP);
    put("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 2\n1 0 0 1 0 1 0 0 0 0 1 4\n");
  }
  ~DatasetTest() override { fs::remove_all(folder_); }

  void put(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  std::string kitti_fault() const {
    try {
      (void)read_kitti(folder_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("dataset_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(DatasetTest, KittiIsReadWithAndWithoutLabels) {
  for (const std::string& calib : {std::string("P0:") + kP + "P1:" + kP1, std::string(kP) + kP1}) {
    put("calib.txt", calib);
    const Dataset set = read_kitti(folder_);
    EXPECT_EQ(set.calibration.left.pinhole, (PinholeCamera{32, 24, 50, 50, 16, 12}));
    EXPECT_DOUBLE_EQ(set.calibration.T_right_left.translation().x(), -0.5);
    ASSERT_EQ(set.frames.size(), 3U);
    EXPECT_EQ(set.frames[1].stamp - set.frames[0].stamp, std::chrono::milliseconds(100)) << "10 Hz without times.txt";
    // Camera forward (z) is body forward (x); camera right (x) is body right (-y).
    EXPECT_TRUE(set.truth[2].T_world_body.translation().isApprox(Eigen::Vector3d(4, -1, 0), 1e-12));
  }
  put("times.txt", "0.0\n0.25\n0.5\n");
  EXPECT_DOUBLE_EQ(read_kitti(folder_).rate_hz, 4.0);
}

TEST_F(DatasetTest, EachFaultOfAKittiFolderIsNamed) {
  put("calib.txt", std::string("P0:") + kP);
  EXPECT_THAT(kitti_fault(), HasSubstr("P0 and P1"));
  put("calib.txt", std::string("P0: 1 2\nP1:") + kP1);
  EXPECT_THAT(kitti_fault(), HasSubstr("12 numbers"));
  put("calib.txt", std::string("P0: nan 0 16 0 0 50 12 0 0 0 1 0\nP1:") + kP1);
  EXPECT_THAT(kitti_fault(), HasSubstr("finite"));
  put("calib.txt", std::string("P0: -50 0 16 0 0 50 12 0 0 0 1 0\nP1:") + kP1);
  EXPECT_THAT(kitti_fault(), HasSubstr("focal"));
  put("calib.txt", std::string("P0:") + kP + "P1: 50 0 16 25 0 50 12 0 0 0 1 0\n");
  EXPECT_THAT(kitti_fault(), HasSubstr("swapped"));
  put("calib.txt", std::string("P0:") + kP + "P1: 60 0 16 -25 0 60 12 0 0 0 1 0\n");
  EXPECT_THAT(kitti_fault(), HasSubstr("rectified"));
  put("calib.txt", std::string("P0:") + kP + "P1:" + kP1);
  put("times.txt", "0\n1\n1e30\n");
  EXPECT_THAT(kitti_fault(), HasSubstr("times.txt"));
  put("times.txt", "0\n2\n1\n");
  EXPECT_THAT(kitti_fault(), HasSubstr("ascend"));
  fs::remove(folder_ / "times.txt");
  put("poses.txt", "1 0 0 0 0 1 0 0 0 0 2 0\n");
  EXPECT_THAT(kitti_fault(), HasSubstr("rigid"));
  fs::remove(folder_ / "poses.txt");
  fs::remove(folder_ / "image_1" / "000002.png");
  EXPECT_THAT(kitti_fault(), HasSubstr("3 images and image_1 2"));
  fs::remove_all(folder_ / "image_0");
  EXPECT_THAT(kitti_fault(), HasSubstr("image_0"));
}

TEST_F(DatasetTest, EurocIsReadAndPairsAreFoundByTheirTime) {
  const std::string sensor =
      "T_BS:\n  data: [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\nresolution: [32, 24]\n"
      "intrinsics: [50, 50, 16, 12]\ndistortion_model: radial-tangential\ndistortion_coefficients: [-0.2, 0.1, 0, 0]\n";
  put("mav0/cam0/sensor.yaml", sensor);
  std::string right = sensor;
  put("mav0/cam1/sensor.yaml", right.replace(right.find("0.2"), 3, "0.5"));
  put("mav0/cam0/data.csv", "#t,f\n1000000000,a.png\n1050000000,b.png\n");
  put("mav0/cam1/data.csv", "#t,f\n1000000000,a.png\n1060000000,b.png\n");
  put("mav0/state_groundtruth_estimate0/data.csv", "#t\n1000000000,1,2,3,1,0,0,0,0\n");
  const Dataset set = read_euroc(folder_);
  ASSERT_EQ(set.frames.size(), 1U);
  EXPECT_EQ(set.unpaired, 2);
  EXPECT_EQ(to_utime(set.frames[0].stamp), 1000000);
  EXPECT_NEAR(set.calibration.T_right_left.translation().x(), -0.3, 1e-12)
      << "0.3 m along the camera's x, which is the body's y";
  EXPECT_TRUE(set.truth[0].T_world_body.translation().isApprox(Eigen::Vector3d(1, 2, 3)));
  put("mav0/state_groundtruth_estimate0/data.csv", "1000000000,abc,2,3,1,0,0,0,0\n");
  EXPECT_THROW((void)read_euroc(folder_), InputError);
  put("mav0/state_groundtruth_estimate0/data.csv", "");
  std::string fov = sensor;
  put("mav0/cam0/sensor.yaml", fov.replace(fov.find("radial-tangential"), 17, "fov"));
  EXPECT_THROW((void)read_euroc(folder_), InputError);
}

TEST_F(DatasetTest, AnImportIsWholeOrNotThere) {
  const fs::path log = folder_ / "out.lcmlog";
  const ImportCounts counts = import_kitti(folder_, log);
  EXPECT_EQ(counts.pairs, 3);
  EXPECT_EQ(counts.poses, 3);
  LogReader reader(log);
  Time last{};
  int events = 0;
  while (const auto event = reader.next()) {
    EXPECT_GE(event->time, last);
    last = event->time;
    ++events;
  }
  EXPECT_EQ(events, 2 + 3 + 3);
  EXPECT_TRUE(fs::exists(log.string() + ".rig.yaml"));
  const fs::path second = folder_ / "second.lcmlog";
  cv::imwrite((folder_ / "image_0" / "000002.png").string(), cv::Mat1b(20, 20, std::uint8_t{1}));
  EXPECT_THROW(import_kitti(folder_, second), InputError);
  put("image_0/000002.png", "no image");
  EXPECT_THROW(import_kitti(folder_, second), InputError);
  for (const auto& entry : fs::directory_iterator(folder_))
    EXPECT_EQ(entry.path().string().find("second"), std::string::npos) << entry.path();
}

TEST(Dataset, TheRealClipIsRead) {
  const char* data = std::getenv("ARPENT_DATA");
  if (data == nullptr) GTEST_SKIP() << "ARPENT_DATA is not set";
  const Dataset set = read_kitti(std::string(data) + "/vo/kitti06_0000-0039");
  EXPECT_EQ(set.frames.size(), 40U);
  EXPECT_NEAR(set.calibration.T_right_left.translation().x(), -0.53715, 1e-4);
  EXPECT_NEAR(set.truth.back().T_world_body.translation().norm(), 46.6, 0.1);
}

}  // namespace
}  // namespace arpent::tools
