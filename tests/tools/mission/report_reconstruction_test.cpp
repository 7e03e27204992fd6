// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/report_reconstruction.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tools/report/mesh_view.h"

namespace arpent::tools {
namespace {

TEST(TimeBudget, CountsFromTheFirstMotionToTheLast) {
  std::vector<StampedTwist> commands;
  const auto add = [&](double speed_mps, double turn_rate_radps, int tenths) {
    for (int i = 0; i < tenths; ++i) {
      commands.push_back(
          {from_utime(100000 * static_cast<std::int64_t>(commands.size())), {speed_mps, turn_rate_radps}});
    }
  };
  add(0, 0, 50);  // before it begins
  add(0.5, 0.8, 30);
  add(0, 0, 20);
  add(0.1, -0.6, 10);
  add(0.1, 0.1, 5);
  add(0, 0, 40);  // after its end
  const TimeBudget budget = time_budget(commands);
  EXPECT_NEAR(budget.driving_s, 3, 1e-9);
  EXPECT_NEAR(budget.standing_s, 2, 1e-9);
  EXPECT_NEAR(budget.turning_s, 1, 1e-9);
  EXPECT_NEAR(budget.creeping_s, 0.5, 1e-9);
  EXPECT_EQ(time_budget({}).driving_s, 0);
}

TEST(OpenView, LooksThroughACeilingOntoAFloor) {
  // A red floor that faces up, a blue ceiling of the same size that faces down.
  TriangleMesh mesh;
  mesh.vertices_m = {{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {0, 3, 0}, {0, 0, 1}, {4, 0, 1}, {4, 3, 1}, {0, 3, 1}};
  for (int i = 0; i < 8; ++i)
    mesh.colors_rgb.push_back(i < 4 ? std::array<std::uint8_t, 3>{255, 0, 0} : std::array<std::uint8_t, 3>{0, 0, 255});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}};
  const cv::Size size(120, 90);
  const Eigen::AlignedBox3f box(Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(4, 3, 1));
  const auto count = [](const cv::Mat3b& picture, int channel) {
    int pixels = 0;
    for (const cv::Vec3b& p : picture) pixels += p[channel] > 100 && p[1] == 0 ? 1 : 0;
    return pixels;
  };
  const cv::Mat3b open = report::draw_open(mesh, {}, box, size);
  EXPECT_GT(count(open, 2), 1000);
  EXPECT_EQ(count(open, 0), 0);
  EXPECT_GT(count(report::draw_birds_eye(mesh, {}, size), 0), 1000) << "drawn closed, the ceiling is seen";
}

TEST(Film, ShowsEachFrameAsOneStep) {
  const std::string folder = testing::TempDir() + "film";
  report::Page page("t", "");
  page.film({cv::Mat(20, 40, CV_8UC3, cv::Scalar(1, 2, 3)), cv::Mat(20, 40, CV_8UC3), cv::Mat(20, 40, CV_8UC3)}, 6,
            "three");
  page.write(folder);
  std::ostringstream text;
  text << std::ifstream(folder + "/report.html").rdbuf();
  EXPECT_NE(text.str().find("steps(3,jump-none)"), std::string::npos);
  EXPECT_NE(text.str().find("background-size:300% 100%"), std::string::npos);
  EXPECT_NE(text.str().find("aspect-ratio:40/20"), std::string::npos);
}

}  // namespace
}  // namespace arpent::tools
