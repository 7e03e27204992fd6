// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `square`: the square mission (config/missions/square.yaml) in lockstep over many seeds: pose against the truth,
// collisions, speed, declared latencies; and the tag cube in the ray-traced arena, seen from 2 m.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>

#include "bench/harness.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "perception/stereo/rectifier.h"
#include "perception/tags/observer.h"
#include "sim/camera/renderer.h"
#include "sim/world/ground.h"
#include "tools/mission/figures.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;

constexpr int kSeeds = 20;
constexpr int kJudgedSeeds = 10;
constexpr int kViews = 100;
constexpr double kViewDistanceM = 2.0;
const fs::path kConfig = ARPENT_SOURCE_DIR "/config";

/// What a child process sends back.
struct Drive {
  double ate_m = 0, yaw_error_deg = 0, realtime_factor = 0;
  int collisions = 0;
  bool done = false;
  /// 95 % of a process' handler times over what it declares: depth, odometry, tag, mapping.
  std::array<double, 4> latency{};
};

double p95(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::array<double, 4> latencies(const tools::MissionSpec& spec, const tools::MissionResult& result) {
  const auto over = [&](const char* process, const char* channel, int declared_us) {
    const auto& timings = result.processes.at(process).handler_ms;
    const auto found = timings.find(channel);
    return found == timings.end() ? 0 : 1e3 * p95(found->second) / declared_us;
  };
  return {over(DepthProcess::kName, channels::kStereoImages, spec.depth.latency_us),
          over(OdometryProcess::kName, channels::kStereoImages, spec.odometry.latency_us),
          over(TagProcess::kName, channels::kStereoImages, spec.tags.latency_us),
          over(MappingProcess::kName, channels::kDepth, spec.mapping.latency_us)};
}

Drive drive(int seed, const fs::path& scratch) {
  tools::MissionOverrides overrides;
  overrides.seed = seed;
  const tools::MissionSpec spec = tools::load_mission(kConfig / "missions/square.yaml", overrides);
  tools::MissionOptions options;
  options.out = scratch / std::to_string(seed);
  options.threads = 1;
  options.progress = false;
  const tools::MissionResult result = tools::run_mission(spec, options);
  const tools::MissionFigures figures = tools::measure(result);
  fs::remove_all(options.out);
  return {figures.ate_m,      figures.yaw_error_deg, figures.realtime_factor,
          figures.collisions, result.done(),         latencies(spec, result)};
}

/// Each drive in a process of its own, two at a time.
std::vector<Drive> drive_all(const fs::path& scratch) {
  std::vector<Drive> drives(kSeeds);
  for (int first = 0; first < kSeeds; first += 2) {
    std::array<int, 2> ends{-1, -1};
    for (int i = 0; i < 2; ++i) {
      int pair[2];
      if (pipe(pair) != 0) throw std::runtime_error("no pipe");
      if (fork() == 0) {
        Drive result;
        try {
          result = drive(first + i + 1, scratch);
        } catch (const std::exception& error) {
          std::fprintf(stderr, "seed %d: %s\n", first + i + 1, error.what());
        }
        [[maybe_unused]] const auto written = write(pair[1], &result, sizeof result);
        _exit(0);
      }
      close(pair[1]);
      ends[static_cast<std::size_t>(i)] = pair[0];
    }
    for (int i = 0; i < 2; ++i) {
      Drive& drive = drives[static_cast<std::size_t>(first + i)];
      if (read(ends[static_cast<std::size_t>(i)], &drive, sizeof drive) != sizeof drive) drive = {};
      close(ends[static_cast<std::size_t>(i)]);
    }
    while (wait(nullptr) > 0) {
    }
  }
  return drives;
}

void measure_drives(bench::Report& report, const fs::path& scratch) {
  const std::vector<Drive> drives = drive_all(scratch);
  std::vector<double> ate, yaw, speed;
  int collisions = 0, done = 0;
  std::array<std::vector<double>, 4> latency;
  for (int i = 0; i < kSeeds; ++i) {
    const Drive& d = drives[static_cast<std::size_t>(i)];
    collisions += d.collisions;
    done += d.done ? 1 : 0;
    for (std::size_t k = 0; k < latency.size(); ++k) latency[k].push_back(d.latency[k]);
    speed.push_back(d.realtime_factor);
    if (i >= kJudgedSeeds) continue;
    ate.push_back(d.ate_m);
    yaw.push_back(d.yaw_error_deg);
  }
  report.add("square.ate_m", bench::median(ate), "m", "bar <= 0.05; median of 10 seeds, no alignment");
  report.add("square.ate_worst_m", *std::max_element(ate.begin(), ate.end()), "m");
  report.add("square.yaw_error_deg", bench::median(yaw), "deg", "bar <= 1");
  report.add("square.done", done, "1", "of 20 seeds");
  report.add("square.collisions", collisions, "1", "bar 0; 20 seeds");
  report.add("sim.realtime_factor", bench::median(speed), "1", "bar >= 1.7; one core, all processes, logging included");
  const std::array<const char*, 4> names{"depth_process", "odometry_process", "tag_process", "mapping_process"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    report.add(fmt::format("latency.{}_p95_over_declared", names[k]), bench::median(latency[k]), "1", "bar <= 1");
  }
}

/// The cube of the arena from 2 m all around, wherever the robot may stand and looks at it to within 20 degrees.
void measure_tags(bench::Report& report) {
  const sim::World world = sim::load_world(kConfig / "worlds/test_arena.yaml");
  const sim::GroundMap ground(world);
  const sim::Renderer renderer(world);
  const StereoCalibration rig = load_rig(kConfig / "rigs/wifibot_stereo.yaml").calibration;
  const sim::CameraModel left(rig.left), right(rig.right);
  const stereo::Rectifier rectifier(rig);
  const sim::TagCube& cube = *world.tag_cube;
  tags::TagCubeConfig config;
  config.x_m = cube.centre_m.x();
  config.y_m = cube.centre_m.y();
  config.z_m = cube.centre_m.z();
  config.yaw_rad = cube.yaw_rad;
  config.edge_m = cube.edge_m;
  config.tag_m = cube.tag_m;
  config.ids.assign(cube.ids.begin(), cube.ids.end());
  const tags::TagObserver observer(config, {}, {}, rectifier.stereo(), rectifier.T_body_rectified());
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<double> position_mm, yaw_mrad;
  int accepted = 0;
  for (int view = 0; view < kViews;) {
    const double bearing = std::numbers::pi * uniform(random);
    const Eigen::Vector2d p =
        cube.centre_m.head<2>() - kViewDistanceM * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    const Pose2 pose{p.x(), p.y(), bearing + 0.35 * uniform(random)};
    if (!world.region.contains({p.x(), p.y(), 0.1}) || ground.hits(pose, {})) continue;
    ++view;
    sim::CameraShot shot;
    shot.seed = static_cast<std::uint64_t>(2 * view);
    const Pose T_world_left = pose.to_pose() * rig.T_body_left;
    const cv::Mat1b left_image = renderer.render(left, T_world_left, shot).image;
    ++shot.seed;
    const cv::Mat1b right_image = renderer.render(right, T_world_left * rig.T_right_left.inverse(), shot).image;
    const auto observation = observer.observe(left_image, right_image);
    if (!observation.accepted()) continue;
    ++accepted;
    const Pose2 found = to_pose2(observation.T_world_body);
    position_mm.push_back(1e3 * (found.position_m() - pose.position_m()).norm());
    yaw_mrad.push_back(1e3 * std::abs(wrap_angle(found.yaw_rad - pose.yaw_rad)));
  }
  report.add("tags.position_error_mm", bench::median(position_mm), "mm", "bar <= 10; median at 2 m");
  report.add("tags.yaw_error_mrad", bench::median(yaw_mrad), "mrad", "bar <= 5");
  report.add("tags.accepted", accepted, "1", "of 100 views");
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  using namespace arpent;
  return bench::run(argc, argv, "The square mission", [](bench::Report& report) {
    cv::setNumThreads(1);
    const fs::path scratch = fs::temp_directory_path() / ("arpent_square_" + std::to_string(getpid()));
    measure_tags(report);
    measure_drives(report, scratch);
    fs::remove_all(scratch);
  });
}
