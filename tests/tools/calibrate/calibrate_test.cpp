// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/error.h"
#include "common/log/event_log.h"
#include "drivers/imu/wire.h"
#include "perception/stereo/calibration_file.h"
#include "perception/stereo/wire.h"
#include "tests/calib/board_picture.h"
#include "tests/calib/simulated_views.h"
#include "tests/tools/calibrate/verb.h"
#include "tools/calibrate/files.h"
#include "tools/calibrate/imu_log.h"
#include "tools/calibrate/live_capture.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class CalibrateVerb : public VerbTest {
 protected:
  CalibrateVerb() : VerbTest("calibrate_test") {}
  void SetUp() override {
    VerbTest::SetUp();
    std::ofstream(folder_ / "target.yaml") << calib::to_yaml(calib::Target{});
  }

  void write_corners(const calib::BoardViews& views) const {
    for (std::size_t c = 0; c < views.cameras.size(); ++c) {
      fs::create_directories(folder_ / "corners" / views.cameras[c].name);
      for (const auto& view : views.views) {
        std::ofstream csv(folder_ / "corners" / views.cameras[c].name / (view.name + ".csv"));
        csv << "kp_x,kp_y,p_x,p_y,p_z\n";
        for (const auto& corner : view.cameras[c]) {
          const Eigen::Vector2d b = views.target.corner_m(corner.index);
          csv << fmt::format("{:.6f},{:.6f},{:.6f},{:.6f},0\n", corner.px.x(), corner.px.y(), b.x(), b.y());
        }
      }
    }
  }
};

TEST_F(CalibrateVerb, FromCornersWritesFilesThatTheStackReads) {
  const auto truth = calib::simulated_rig(DistortionModel::kRadialTangential);
  calib::SimulationOptions options;
  options.views = 16;
  write_corners(calib::simulate_views(truth, options, 1));
  const std::string at = folder_.string();
  ASSERT_EQ(
      run(fmt::format("stereo --target {0}/target.yaml --corners {0}/corners --out {0}/out --json {0}/out.json", at)),
      0)
      << output_;
  EXPECT_THAT(output_, HasSubstr("Good: use it."));
  EXPECT_THAT(output_, HasSubstr("1280 x 1024")) << "the smallest usual size that holds the corners";
  const auto camchain = stereo::read_calibration(folder_ / "out/camchain.yaml", 0, 0);
  const auto opencv = stereo::read_calibration(folder_ / "out/opencv.yaml", 0, 0);
  const auto rig = load_rig(folder_ / "out/rig.yaml").calibration;
  for (const auto& read : {camchain, opencv, rig}) {
    EXPECT_NEAR(read.left.pinhole.fx_px, truth.cameras[0].pinhole.fx_px, 0.5);
    EXPECT_NEAR(read.right.coefficients[0], truth.cameras[1].coefficients[0], 0.002);
    EXPECT_NEAR(read.T_right_left.translation().x(), -0.26, 1e-4);
  }
  const auto json = nlohmann::json::parse(std::ifstream(folder_ / "out.json"));
  EXPECT_EQ(json["verdict"], "good");
  EXPECT_EQ(json["cameras"].size(), 2U);
  EXPECT_GT(fs::file_size(folder_ / "out/report.html"), 10000U);
}

TEST_F(CalibrateVerb, WritesNoBadCalibrationUnlessForced) {
  calib::SimulationOptions options;
  options.views = 8;
  options.tilt_rad = 0.02;
  write_corners(calib::simulate_views(calib::simulated_rig(DistortionModel::kRadialTangential), options, 1));
  const std::string arguments =
      fmt::format("stereo --target {0}/target.yaml --corners {0}/corners --out {0}/out", folder_.string());
  EXPECT_EQ(run(arguments), 1) << output_;
  EXPECT_THAT(output_, HasSubstr("no parallax"));
  EXPECT_FALSE(fs::exists(folder_ / "out/camchain.yaml"));
  EXPECT_TRUE(fs::exists(folder_ / "out/report.html"));
  EXPECT_EQ(run(arguments + " --force"), 0) << output_;
  EXPECT_TRUE(fs::exists(folder_ / "out/camchain.yaml"));
}

TEST_F(CalibrateVerb, NamesWhatCannotBeUsed) {
  const std::string at = folder_.string();
  EXPECT_EQ(run(fmt::format("stereo --target {0}/none.yaml --images {0} --out {0}/out", at)), 2);
  EXPECT_THAT(output_, HasSubstr("none.yaml: cannot be read"));
  EXPECT_EQ(run(fmt::format("stereo --target {0}/target.yaml --images {0} --out {0}/out", at)), 2);
  EXPECT_THAT(output_, HasSubstr("has no .png"));
  for (const int width : {64, 80}) cv::imwrite(fmt::format("{}/left{}.png", at, width), cv::Mat1b(48, width, 7));
  EXPECT_EQ(run(fmt::format("stereo --target {0}/target.yaml --images {0} --out {0}/out", at)), 2);
  EXPECT_THAT(output_, HasSubstr("mixed sizes"));
  EXPECT_EQ(run("stereo"), 2);
}

TEST_F(CalibrateVerb, HasASentenceForViewsThatCannotBeUsed) {
  const auto rig = calib::simulated_rig(DistortionModel::kRadialTangential);
  const std::string arguments =
      fmt::format("stereo --target {0}/target.yaml --corners {0}/corners --out {0}/out", folder_.string());
  calib::SimulationOptions options;
  options.views = 3;
  write_corners(calib::simulate_views(rig, options, 1));
  EXPECT_EQ(run(arguments), 2);
  EXPECT_THAT(output_, HasSubstr("too few views: cam0 sees the board in 3 of them"));
  options.views = 8;
  auto views = calib::simulate_views(rig, options, 2);
  const auto together = views;
  // Two clocks: no picture of the right camera has the name of one of the left.
  for (std::size_t v = 0; v < 8; ++v) views.views[v].cameras[v % 2].clear();
  write_corners(views);
  EXPECT_EQ(run(arguments), 2);
  EXPECT_THAT(output_, HasSubstr("never sees the board together with another camera"));
  EXPECT_THAT(output_, HasSubstr("are the clocks the same?"));
  views = together;
  for (auto& view : views.views) std::swap(view.cameras[0], view.cameras[1]);
  write_corners(views);
  EXPECT_EQ(run(arguments), 1);
  EXPECT_THAT(output_, HasSubstr("swapped"));
}

TEST_F(CalibrateVerb, CornersOffTheBoardAreRefused) {
  calib::SimulationOptions options;
  options.views = 5;
  write_corners(calib::simulate_views(calib::simulated_rig(DistortionModel::kRadialTangential), options, 1));
  calib::Target smaller;
  smaller.tag_m = 0.08;
  EXPECT_THROW((void)views_from_corners(smaller, folder_ / "corners", {0, 0}), InputError);
}

TEST_F(CalibrateVerb, FindsTheCamerasOfAFolderHoweverTheyAreNamed) {
  const auto touch = [&](const std::string& file) {
    fs::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << "x";
  };
  touch("a/left01.png"), touch("a/right01.png"), touch("a/left_02.PNG"), touch("a/notes.txt");
  auto cameras = find_camera_files(folder_ / "a", {".png"});
  ASSERT_EQ(cameras.size(), 2U);
  EXPECT_EQ(cameras["left"].count("01") + cameras["left"].count("02") + cameras["right"].count("01"), 3U);
  touch("b/mav0/cam0/data/100.png"), touch("b/mav0/cam1/data/100.png"), touch("b/mav0/cam1/data/200.png");
  cameras = find_camera_files(folder_ / "b", {".png"});
  ASSERT_EQ(cameras.size(), 2U);
  EXPECT_EQ(cameras["cam1"].size(), 2U);
  touch("c/x.png"), touch("c/y.png");
  EXPECT_EQ(find_camera_files(folder_ / "c", {".png"})["cam0"].size(), 2U);
}

TEST_F(CalibrateVerb, TakesPairsFromALogBetweenWhichTheBoardMoved) {
  const auto rig = calib::simulated_rig(DistortionModel::kRadialTangential);
  const sim::CameraModel left(rig.cameras[0]), right(rig.cameras[1]);
  const auto boards = calib::simulated_boards({}, 1);
  LogWriter log(folder_ / "pairs.lcm");
  for (const std::size_t board : {0U, 0U, 1U}) {  // the second pair shows the first board again
    static std::int64_t utime = 0;
    stereo::StereoPair pair{from_utime(utime += 200000), 1, calib::draw_board({}, left, boards[board], 1),
                            calib::draw_board({}, right, rig.T_cam_first[1] * boards[board], 2)};
    const auto message = stereo::to_wire(pair, true);
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    ASSERT_TRUE(log.write(from_utime(utime), channels::kStereoImages, bytes));
  }
  log.close();
  const auto views = views_from_log({}, folder_ / "pairs.lcm", 10, [](auto, auto) {});
  ASSERT_EQ(views.views.size(), 2U);
  EXPECT_EQ(views.views[0].name, "200000");
  EXPECT_EQ(views.views[1].name, "600000");
  EXPECT_GT(views.views[0].cameras[1].size(), 50U);
}

/// Live pictures of a board that is held still at one place after the other.
TEST_F(CalibrateVerb, LiveGuidanceFollowsThePicturesOnTheBus) {
  const auto rig = calib::simulated_rig(DistortionModel::kRadialTangential);
  const sim::CameraModel left(rig.cameras[0]), right(rig.cameras[1]);
  LockstepExecutor executor(from_utime(0));
  std::vector<std::string> lines;
  LiveCapture capture(executor.add_process("calibrate").bus, {}, [&](const auto& line) { lines.push_back(line); });
  EXPECT_THROW((void)capture.views(), InputError) << "nothing came yet";
  std::int64_t utime = 0;
  const auto show = [&](const cv::Mat1b& a, const cv::Mat1b& b) {
    utime += 200000;
    executor.inject(from_utime(utime), channels::kStereoImages,
                    encode(stereo::to_wire({from_utime(utime), utime / 200000, a, b}, false)));
    executor.run_until(from_utime(utime));
  };
  show(cv::Mat1b(1024, 1280, 90), cv::Mat1b(1024, 1280, 90));
  for (const std::size_t board : {0U, 1U}) {
    const Pose T = calib::simulated_boards({}, 1)[board];
    const auto a = calib::draw_board({}, left, T, board),
               b = calib::draw_board({}, right, rig.T_cam_first[1] * T, board);
    show(a, b);
    show(a, b);
  }
  show(cv::Mat1b(512, 640, 90), cv::Mat1b(512, 640, 90));
  ASSERT_EQ(lines.size(), 6U) << testing::PrintToString(lines);
  EXPECT_EQ(lines[0], "no board in sight");
  EXPECT_EQ(lines[1], "hold it still");
  EXPECT_THAT(lines[2], HasSubstr("view 1 taken"));
  EXPECT_THAT(lines[2], HasSubstr("next: show it in the "));
  EXPECT_THAT(lines[4], HasSubstr("view 2 taken"));
  EXPECT_THAT(lines[5], HasSubstr("mixed sizes"));
  EXPECT_EQ(capture.views().views.size(), 2U);
  EXPECT_FALSE(capture.complete());
}

/// A unit at rest for `seconds` at 20 Hz with white noise; it is turned at `moved_s`.
void write_imu_log(const fs::path& file, int seconds, int moved_s) {
  std::mt19937 generator(1);
  std::normal_distribution<double> gyro(0, 1e-3), accelerometer(0, 1e-2);
  LogWriter log(file);
  for (int i = 0; i < 20 * seconds; ++i) {
    imu::Reading reading{from_utime(50000LL * i), {}, {}};
    for (int k = 0; k < 3; ++k) {
      reading.angular_velocity_radps[k] = gyro(generator) + (i / 20 == moved_s ? 0.2 : 0.0);
      reading.acceleration_mps2[k] = accelerometer(generator) + (k == 2 ? 9.81 : 0);
    }
    const imu_t message = imu::to_wire(reading, i);
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    if (i % 5000 != 77) log.write(reading.stamp, channels::kImu, bytes);  // a few are lost
  }
  log.close();
}

TEST_F(CalibrateVerb, MeasuresTheNoiseOfAUnitAtRest) {
  write_imu_log(folder_ / "imu.lcm", 900, -1);
  ASSERT_EQ(run(fmt::format("imu --log {0}/imu.lcm --out {0}/imu", folder_.string())), 0) << output_;
  const auto result = measure_imu_noise(load_static_imu(folder_ / "imu.lcm"));
  EXPECT_NEAR(result.rate_hz, 20, 1e-6);
  // White noise of s per sample at 20 Hz is s / sqrt(20) per sqrt(Hz).
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(result.axes[k].white / (1e-3 / std::sqrt(20.0)), 1, 0.05);
  for (std::size_t k = 3; k < 6; ++k) EXPECT_NEAR(result.axes[k].white / (1e-2 / std::sqrt(20.0)), 1, 0.05);
  EXPECT_TRUE(fs::exists(folder_ / "imu/imu.yaml"));
  EXPECT_TRUE(fs::exists(folder_ / "imu/allan.csv"));
  EXPECT_THAT(to_imu_yaml(result), HasSubstr("gyroscope_noise_density: 2."));
}

TEST_F(CalibrateVerb, RefusesAUnitThatWasMovedOrALogThatIsTooShort) {
  write_imu_log(folder_ / "moved.lcm", 700, 300);
  EXPECT_EQ(run(fmt::format("imu --log {0}/moved.lcm --out {0}/imu", folder_.string())), 2);
  EXPECT_THAT(output_, HasSubstr("was moved 300 s after the start"));
  write_imu_log(folder_ / "short.lcm", 60, -1);
  EXPECT_EQ(run(fmt::format("imu --log {0}/short.lcm --out {0}/imu", folder_.string())), 2);
  EXPECT_THAT(output_, HasSubstr("ten minutes are the least"));
}

TEST_F(CalibrateVerb, PrintsABoard) {
  EXPECT_EQ(run(fmt::format("target --target {0}/target.yaml --pdf {0}/board.pdf --page a0", folder_.string())), 0)
      << output_;
  EXPECT_GT(fs::file_size(folder_ / "board.pdf"), 10000U);
  EXPECT_EQ(run(fmt::format("target --target {0}/target.yaml --pdf {0}/board.pdf --page a4", folder_.string())), 2);
  EXPECT_THAT(output_, HasSubstr("does not fit"));
}

}  // namespace
}  // namespace arpent::tools
