// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent calibrate WHAT`: boards to print, cameras, inertial units, wheels, the camera's place
// (docs/calibration.md).
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <opencv2/core.hpp>

#include "calib/artwork.h"
#include "calib/output.h"
#include "common/atomic_file.h"
#include "common/bus/lcm_bus.h"
#include "common/config/rig.h"
#include "common/error.h"
#include "tools/calibrate/camera_imu_log.h"
#include "tools/calibrate/drive_report.h"
#include "tools/calibrate/files.h"
#include "tools/calibrate/imu_log.h"
#include "tools/calibrate/live_capture.h"
#include "tools/calibrate/stereo_report.h"
#include "tools/progress.h"

namespace {

using namespace arpent;
namespace fs = std::filesystem;

struct Flags {
  std::string target, pdf, page = "a4", images, corners, log, out, json, lens = "radtan",
                           lcm_url = arpent::kDefaultLcmUrl;
  std::vector<int> size{0, 0};
  std::size_t most_views = 80;
  bool force = false, live = false;
  tools::DriveSources drive;
};

/// Width and height [m].
std::pair<double, double> page_size(const std::string& name) {
  static const std::map<std::string, std::pair<double, double>> sizes{{"a4", {0.210, 0.297}},
                                                                      {"a3", {0.297, 0.420}},
                                                                      {"a2", {0.420, 0.594}},
                                                                      {"a1", {0.594, 0.841}},
                                                                      {"a0", {0.841, 1.189}}};
  return sizes.at(name);
}

int print_target(const Flags& flags) {
  const calib::Target target = calib::load_target(flags.target);
  auto [width_m, height_m] = page_size(flags.page);
  const Eigen::Vector2d size_m = target.size_m();
  if (size_m.x() > size_m.y()) std::swap(width_m, height_m);
  atomic_write(flags.pdf, calib::board_pdf(target, width_m, height_m));
  std::printf("%s: a board of %.0f x %.0f mm on %s; print at 100 %% and measure the bar\n", flags.pdf.c_str(),
              1e3 * size_m.x(), 1e3 * size_m.y(), flags.page.c_str());
  return 0;
}

calib::BoardViews load_views(const Flags& flags) {
  const calib::Target target = calib::load_target(flags.target);
  if (!flags.images.empty()) {
    return tools::views_from_images(target, flags.images,
                                    [](auto done, auto total) { tools::show_progress("corners", done, total); });
  }
  if (!flags.log.empty()) {
    return tools::views_from_log(target, flags.log, flags.most_views,
                                 [](auto done, auto total) { tools::show_progress("corners", done, total); });
  }
  if (flags.live) return tools::capture_live(flags.lcm_url, target);
  auto views = tools::views_from_corners(target, flags.corners, {flags.size[0], flags.size[1]});
  if (flags.size[0] == 0) {
    std::printf("took the images to be %d x %d: --size says otherwise\n", views.cameras[0].width_px,
                views.cameras[0].height_px);
  }
  return views;
}

void write_calibration(const calib::Calibration& found, const std::string& rig_file, const fs::path& out) {
  atomic_write(out / "camchain.yaml", calib::to_camchain_yaml(found.rig));
  if (found.rig.cameras.size() < 2 || !find_faults(calib::to_stereo(found.rig)).empty()) return;
  const StereoCalibration stereo = calib::to_stereo(found.rig);
  atomic_write(out / "opencv.yaml", calib::to_opencv_yaml(stereo));
  RigConfig before;
  before.name = "calibrated";
  if (!rig_file.empty()) before = load_rig(rig_file).config;
  atomic_write(out / "rig.yaml", config::to_yaml(calib::to_rig_config(stereo, before)));
}

int calibrate_cameras(const Flags& flags) {
  cv::setNumThreads(1);
  calib::CalibrationParams params;
  if (flags.lens == "equidistant") params.model = DistortionModel::kEquidistant;
  const calib::BoardViews views = load_views(flags);
  const calib::Calibration found = calib::calibrate(views, params);
  const calib::Quality quality = calib::assess(found);
  std::printf("%s", tools::summarize(found, quality).c_str());
  fs::create_directories(flags.out);
  tools::write_report(found, quality, flags.out);
  if (!flags.json.empty()) atomic_write(flags.json, tools::to_json(found, quality).dump(1) + "\n");
  if (quality.grade == calib::Grade::kBad && !flags.force) {
    std::printf("%s: only the report was written (--force writes the rest)\n", flags.out.c_str());
    return 1;
  }
  write_calibration(found, flags.drive.rig, flags.out);
  std::printf("%s: camchain.yaml, report.html%s\n", flags.out.c_str(),
              found.rig.cameras.size() > 1 ? ", rig.yaml and more" : "");
  return 0;
}

int measure_imu(const Flags& flags) {
  const auto result = tools::measure_imu_noise(tools::load_static_imu(flags.log));
  std::printf("%s", tools::summarize(result).c_str());
  tools::write_imu_files(result, flags.out);
  std::printf("%s: imu.yaml, allan.csv, report.html\n", flags.out.c_str());
  return 0;
}

int calibrate_drive(tools::DriveSubject subject, Flags flags) {
  cv::setNumThreads(1);
  flags.drive.log = flags.log;
  const tools::DriveLog drive =
      tools::load_drive(flags.drive, [](auto done, auto total) { tools::show_progress("log", done, total); });
  const calib::DriveCalibration found = calib::calibrate_drive(drive.input);
  std::printf("%s", tools::summarize(subject, drive, found).c_str());
  tools::write_drive_files(subject, drive, found, flags.out);
  if (!flags.json.empty()) atomic_write(flags.json, tools::to_json(subject, drive, found).dump(1) + "\n");
  std::printf("%s: %s, report.html\n", flags.out.c_str(),
              subject == tools::DriveSubject::kWheels ? "wheels.yaml" : "rig.yaml");
  return 0;
}

int calibrate_camera_imu(const Flags& flags) {
  cv::setNumThreads(1);
  const tools::CameraImuLog log =
      tools::load_camera_imu({flags.log, flags.drive.rig, flags.target},
                             [](auto done, auto total) { tools::show_progress("log", done, total); });
  const calib::CameraImuCalibration found = calib::calibrate_camera_imu(log.input);
  std::printf("%s", tools::summarize(log, found).c_str());
  tools::write_camera_imu_files(log, found, flags.out);
  if (!flags.json.empty()) atomic_write(flags.json, tools::to_json(log, found).dump(1) + "\n");
  std::printf("%s: camchain-imucam.yaml, report.html%s\n", flags.out.c_str(),
              found.rotation_observed() ? ", imu_mount.yaml" : "");
  return 0;
}

void add_target(CLI::App& app, Flags& flags) {
  CLI::App* sub = app.add_subcommand("target", "print a board, true to scale");
  sub->add_option("--target", flags.target, "target.yaml as Kalibr's; tagBorder: 1 or 2 (default)")->required();
  sub->add_option("--pdf", flags.pdf, "file to write")->required();
  sub->add_option("--page", flags.page, "paper")
      ->capture_default_str()
      ->check(CLI::IsMember({"a4", "a3", "a2", "a1", "a0"}));
}

void add_stereo(CLI::App& app, Flags& flags) {
  CLI::App* sub =
      app.add_subcommand("stereo", "lenses and places of one, two or more cameras that are fixed to each other");
  sub->add_option("--target", flags.target, "target.yaml as Kalibr's")->required();
  auto* input = sub->add_option_group("input");
  input->add_option("--images", flags.images, "folder: cam0/ cam1/ … or left*, right*; EuRoC's mav0");
  input->add_option("--corners", flags.corners,
                    "folder of CSV files, one per view and camera: kp_x, kp_y, p_x, p_y, p_z");
  input->add_option("--log", flags.log, "LCM log with STEREO_IMAGES");
  input->add_flag("--live", flags.live, "STEREO_IMAGES from the bus, with advice what to show next");
  input->require_option(1);
  sub->add_option("--lcm-url", flags.lcm_url, "bus, for --live")->capture_default_str();
  sub->add_option("--out", flags.out, "folder for camchain.yaml, opencv.yaml, rig.yaml, report.html")->required();
  sub->add_option("--json", flags.json, "write all figures to this file");
  sub->add_option("--lens", flags.lens, "distortion")
      ->capture_default_str()
      ->check(CLI::IsMember({"radtan", "equidistant"}));
  sub->add_option("--size", flags.size, "width,height of the images, for --corners [px]")->delimiter(',')->expected(2);
  sub->add_option("--max-views", flags.most_views, "views taken from a log")
      ->capture_default_str()
      ->check(CLI::Range(4, 1000));
  sub->add_option("--rig", flags.drive.rig, "rig file whose mounting, range and rate rig.yaml takes over");
  sub->add_flag("--force", flags.force, "write a calibration that is bad, too");
}

void add_imu(CLI::App& app, Flags& flags) {
  CLI::App* sub = app.add_subcommand("imu", "noise of an inertial unit from a log at rest (three hours are good)");
  sub->add_option("--log", flags.log, "LCM log with IMU")->required();
  sub->add_option("--out", flags.out, "folder for imu.yaml (Kalibr's), allan.csv, report.html")->required();
}

void add_drive(CLI::App& app, const char* name, const char* what, const char* out, Flags& flags) {
  CLI::App* sub = app.add_subcommand(name, what);
  sub->add_option("--log", flags.log, "LCM log of a drive: WHEEL_STATE, and ODOMETRY, TAG_OBSERVATION or STEREO_IMAGES")
      ->required();
  sub->add_option("--out", flags.out, out)->required();
  sub->add_option("--json", flags.json, "write all figures to this file");
  sub->add_option("--robot", flags.drive.robot, "robot file, if the log brings none");
  sub->add_option("--rig", flags.drive.rig, "rig file, if the log brings none");
  sub->add_option("--tags", flags.drive.tags, "configuration of tag_process with the cube, if the log brings none");
  sub->add_option("--by", flags.drive.by,
                  "the camera's motion: by tags, or by odometry; auto: tags, if they are mostly seen")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "tags", "odometry"}));
}

void add_camera_imu(CLI::App& app, Flags& flags) {
  CLI::App* sub = app.add_subcommand("camera-imu", "rotation, place and delay between camera and inertial unit");
  sub->add_option("--log", flags.log, "LCM log of an excited motion: IMU, and ODOMETRY or STEREO_IMAGES")->required();
  sub->add_option("--out", flags.out, "folder for camchain-imucam.yaml, imu_mount.yaml, report.html")->required();
  sub->add_option("--target", flags.target, "target.yaml of a board in the pictures; else the odometry is used");
  sub->add_option("--json", flags.json, "write all figures to this file");
  sub->add_option("--rig", flags.drive.rig, "rig file, if the log brings none");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Calibration (docs/calibration.md). Exit code 1: a bad calibration; 2: input that cannot be used."};
  app.name("arpent calibrate");
  app.require_subcommand(1);
  Flags flags;
  add_target(app, flags);
  add_stereo(app, flags);
  add_imu(app, flags);
  add_drive(app, "wheels", "scales, track and clock of the wheels from a drive", "folder for wheels.yaml, report.html",
            flags);
  add_drive(app, "body", "the camera's place on the body from a drive", "folder for rig.yaml, report.html", flags);
  add_camera_imu(app, flags);
  try {
    app.parse(argc, argv);
    if (app.got_subcommand("camera-imu")) return calibrate_camera_imu(flags);
    if (app.got_subcommand("wheels")) return calibrate_drive(tools::DriveSubject::kWheels, flags);
    if (app.got_subcommand("body")) return calibrate_drive(tools::DriveSubject::kBody, flags);
    if (app.got_subcommand("target")) return print_target(flags);
    return app.got_subcommand("imu") ? measure_imu(flags) : calibrate_cameras(flags);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "calibrate: %s\n", error.what());
    return 2;
  } catch (const fs::filesystem_error& error) {
    std::fprintf(stderr, "calibrate: %s\n", error.what());
    return 2;
  }
}
