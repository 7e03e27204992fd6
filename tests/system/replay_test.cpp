// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The whole chain on a short rendered drive: import, replay in lockstep and live, trajectory, mesh, report; and the
// commands as a user calls them.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "common/config/config.h"
#include "common/error.h"
#include "sim/scene.h"
#include "tools/evaluation/mesh.h"
#include "tools/import/import.h"
#include "tools/replay/summary.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;

class ReplayTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    fs::create_directories(folder());
    if (!fs::exists(log())) import_rendered(1.6, log());
  }
  static fs::path folder() { return fs::path(testing::TempDir()) / ("replay_test_" + std::to_string(getpid())); }
  static fs::path log() { return folder() / "drive.lcmlog"; }
  static void TearDownTestSuite() { fs::remove_all(folder()); }

  static int run(const std::string& arguments) {
    const std::string command =
        std::string(ARPENT_BIN_DIR) + "/" + arguments + " >" + (folder() / "out.txt").string() + " 2>&1";
    const int status = std::system(command.c_str());
    return WEXITSTATUS(status);
  }
  static std::string output() {
    std::stringstream text;
    text << std::ifstream(folder() / "out.txt").rdbuf();
    return text.str();
  }
  static std::size_t rows(const fs::path& file) {
    std::ifstream in(file);
    std::size_t count = 0;
    for (std::string line; std::getline(in, line);) count += !line.empty() && line[0] != '#' ? 1 : 0;
    return count;
  }
};

TEST_F(ReplayTest, TwoLockstepRunsGiveTheSameBytesWithAnyNumberOfThreads) {
  const ReplayInput input = open_log(log(), folder(), "", {});
  ReplayOptions options;
  options.threads = 1;
  const ReplayResult a = run_lockstep(input, options);
  options.threads = 2;
  const ReplayResult b = run_lockstep(input, options);
  EXPECT_EQ(a.log_crc, b.log_crc);
  EXPECT_TRUE(compare(a, b).identical());
  EXPECT_EQ(a.odometry.size(), input.pairs.size());
  EXPECT_FALSE(a.depth_crc.empty());
}

TEST_F(ReplayTest, TheDriveIsFollowedAndTheMapIsTheArena) {
  const ReplayInput input = open_log(log(), folder(), "", {});
  const ReplayResult result = run_lockstep(input, {});
  const Summary summary = summarise(input, result, nullptr);
  ASSERT_TRUE(summary.errors);
  EXPECT_LT(summary.errors->ate_m.rmse, 0.02);
  // The map lies in odom, which is the body at the first pair.
  TriangleMesh arena = sim::to_mesh(sim::make_test_arena());
  const Eigen::Isometry3f T_odom_world = input.truth.front().T_ref_body.inverse().cast<float>();
  for (auto& p : arena.vertices_m) p = T_odom_world * p;
  evaluation::MeshParams params;
  params.samples_per_m2 = 100;
  const auto errors = evaluation::evaluate_mesh(arena, result.mesh, params);
  EXPECT_LT(errors.rmse_cm, 3.0);
  EXPECT_GT(errors.coverage_percent, 10.0);
  EXPECT_LT(errors.beyond_percent, 10.0);
}

TEST_F(ReplayTest, AReplayOfItsOwnOutputReproducesItByteForByte) {
  const ReplayInput input = open_log(log(), folder(), "", {});
  ReplayOptions options;
  options.out_log = folder() / "out.lcmlog";
  const ReplayResult first = run_lockstep(input, options);
  ReplayInput again = input;
  again.log = options.out_log;
  EXPECT_TRUE(compare(first, run_lockstep(again, {})).identical());
}

TEST_F(ReplayTest, OnlyMappingTakesDepthAndOdometryFromTheLog) {
  const ReplayInput input = open_log(log(), folder(), "", {});
  ReplayOptions options;
  options.out_log = folder() / "out2.lcmlog";
  const ReplayResult first = run_lockstep(input, options);
  ReplayInput again = input;
  again.log = options.out_log;
  ReplayOptions only;
  only.processes = {"mapping"};
  const ReplayResult second = run_lockstep(again, only);
  EXPECT_EQ(first.map_digests, second.map_digests);
}

TEST_F(ReplayTest, SeekDurationAndStepChooseThePairs) {
  const ReplayInput input = open_log(log(), folder(), "", {});
  ReplayOptions options;
  options.start_s = 0.4;
  options.duration_s = 0.6;
  options.step = 2;
  EXPECT_EQ(run_lockstep(input, options).pairs, 2) << "of the pairs at 0.4, 0.6, 0.8 s those with an even number";
}

TEST_F(ReplayTest, LiveProcessesGiveTheSameDepthAndMap) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "stereo under the thread sanitizer does not keep up with real time, and a live process drops pairs";
#endif
  const ReplayInput input = open_log(log(), folder(), "", {});
  const ReplayResult lockstep = run_lockstep(input, {});
  const ReplayResult live = run_live(input, {}, ARPENT_BIN_DIR, folder() / "live");
  const ReplayDifference difference = compare(lockstep, live);
  EXPECT_EQ(difference.depth_different, 0);
  EXPECT_EQ(difference.map_different, 0);
  EXPECT_TRUE(difference.mesh_equal);
  EXPECT_EQ(live.processes.size(), 3U);
}

TEST_F(ReplayTest, TheCommandWritesTrajectoryMeshAndReport) {
  const std::string f = folder().string();
  ASSERT_EQ(run("arpent-replay " + log().string() + " --trajectory " + f + "/t.tum --trajectory-frame cam0 --mesh " +
                f + "/m.ply --report " + f + "/report"),
            0)
      << output();
  EXPECT_EQ(rows(folder() / "t.tum"), 9U) << "one row per pair";
  EXPECT_GT(read_ply(folder() / "m.ply").triangles.size(), 1000U);
  for (const char* name : {"report.html", "mesh.ply", "trajectory.tum"})
    EXPECT_TRUE(fs::exists(folder() / "report" / name)) << name;
  EXPECT_NE(output().find("report.html"), std::string::npos);
}

TEST_F(ReplayTest, ADamagedLogIsReplayedWithAWarning) {
  const fs::path damaged = folder() / "damaged.lcmlog";
  fs::copy_file(log(), damaged, fs::copy_options::overwrite_existing);
  {
    std::fstream file(damaged, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(fs::file_size(damaged) / 2));
    file.write("????????????????????????????????", 32);
  }
  EXPECT_EQ(run("arpent-replay " + damaged.string()), 0) << output();
  fs::resize_file(damaged, fs::file_size(damaged) * 2 / 3);
  EXPECT_EQ(run("arpent-replay " + damaged.string()), 0) << output();
  EXPECT_NE(output().find("damaged"), std::string::npos) << output();
}

TEST_F(ReplayTest, BadInputIsOneClearErrorAndExitCode2) {
  const auto expect_refused = [&](const std::string& arguments, const std::string& word) {
    EXPECT_EQ(run(arguments), 2) << arguments << output();
    EXPECT_NE(output().find(word), std::string::npos) << arguments << ": " << output();
  };
  expect_refused("arpent-replay /no/such/log", "/no/such/log");
  expect_refused("arpent-replay " + log().string() + " --set mapping.tsdf.voxel_m=-1", "must be between");
  expect_refused("arpent-replay " + log().string() + " --set mapping.voxel=1", "unknown key");
  expect_refused("arpent-replay " + log().string() + " --rig /no/rig.yaml", "/no/rig.yaml");
  expect_refused("arpent-replay " + log().string() + " --mesh /no/such/folder/m.ply", "/no/such/folder");
  expect_refused("arpent-import kitti /no/such/folder --out " + (folder() / "x").string(), "/no/such/folder");
  expect_refused("arpent-depth /no/left.png /no/right.png --out " + (folder() / "x").string(), "/no/left.png");
  expect_refused("depth_process --set rig=" + (folder() / "rig.yaml").string() + " --set colour=1", "unknown key");
  expect_refused("mapping_process --print-config", "rig");
  expect_refused("depth_process --nonsense", "nonsense");
}

TEST_F(ReplayTest, PrintConfigLoadsBack) {
  const ReplayInput input = open_log(log(), folder(), "", {});
  ASSERT_EQ(run("depth_process --print-config --set matcher.max_disparity_px=64 --set rig=" + input.rig_file.string()),
            0);
  const DepthConfig config = config::load_text<DepthConfig>("printed", output());
  EXPECT_EQ(config.matcher.max_disparity_px, 64);
  EXPECT_EQ(config.rig, input.rig_file);
}

}  // namespace
}  // namespace arpent::tools
