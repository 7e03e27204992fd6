// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// From the map to targets and back: a robot that goes where it is sent completes a small room, and it ends.
#include "planning/viewpoints/exploration_targets.h"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <set>

#include "common/error.h"
#include "tests/planning/viewpoints/grid_free_space.h"

namespace arpent::planning {
namespace {

using std::numbers::pi;

constexpr double kLength = 5.0, kWidth = 4.0, kHeight = 1.8;
const PinholeCamera kCamera{160, 128, 94.25, 94.25, 79.5, 63.5};

Pose T_body_cam() {
  Pose T = Pose::Identity();
  T.linear() = R_body_from_camera_axes();
  T.translation() = Eigen::Vector3d(0.20, 0.13, 0.40);
  return T;
}

enum class Ceiling : std::uint8_t { kClosed, kOpen };

/// Depth images of an empty room with one corner at the origin; none of the sky.
stereo::DepthMap render(const Pose& T_map_cam, Ceiling ceiling) {
  stereo::DepthMap depth{kCamera, cv::Mat1f(128, 160, 0.0F), cv::Mat1f(128, 160, 0.0F)};
  const Eigen::Vector3d size(kLength, kWidth, kHeight), eye = T_map_cam.translation();
  for (int v = 0; v < 128; ++v) {
    for (int u = 0; u < 160; ++u) {
      const Eigen::Vector3d ray = T_map_cam.linear() * kCamera.unproject(u, v, 1);
      double z = 1e9;
      for (int k = 0; k < 3; ++k) {
        if (ray[k] != 0) z = std::min(z, ((ray[k] > 0 ? size[k] : 0) - eye[k]) / ray[k]);
      }
      if (ceiling == Ceiling::kOpen && eye.z() + z * ray.z() > kHeight - 1e-6) continue;
      if (z < 0.3 || z > 5) continue;
      depth.depth_m(v, u) = static_cast<float>(z);
      depth.sigma_m(v, u) = 0.005F;
    }
  }
  return depth;
}

class Robot {
 public:
  explicit Robot(const std::string& preset, double min_viewpoint_m2 = ViewpointParams{}.min_viewpoint_m2,
                 Ceiling ceiling = Ceiling::kClosed, double blank_factor = ViewpointParams{}.blank_factor)
      : ceiling_(ceiling),
        targets_(params_for(preset, min_viewpoint_m2, ceiling, blank_factor),
                 make_level_camera({kCamera, 0.26}, T_body_cam(), 0.3, 5.0)),
        map_(map_params()) {
    for (int i = 0; i < 8; ++i) look({1.5, 2, i * pi / 4}, 2);
  }

  void look(const Pose2& pose, int looks) {
    pose_ = pose;
    const Pose T_map_cam = pose.to_pose() * T_body_cam();
    const stereo::DepthMap depth = render(T_map_cam, ceiling_);
    for (int i = 0; i < looks; ++i) {
      ASSERT_TRUE(map_.integrate(depth, T_map_cam));
      targets_.update(map_);
      targets_.note_looks(map_, {&pose, 1});
    }
  }

  Targets plan() { return targets_.plan(map_, ground_, pose_); }
  [[nodiscard]] std::vector<Certificate> certify() const { return targets_.certify(map_, ground_, pose_).certificates; }
  [[nodiscard]] const mapping::IncompleteSurface& surface() const { return targets_.surface(); }

 private:
  static ViewpointParams params_for(const std::string& preset, double min_viewpoint_m2, Ceiling ceiling,
                                    double blank_factor) {
    ViewpointParams params;
    params.blank_factor = blank_factor;
    if (ceiling == Ceiling::kOpen) params.least_piece_m = 0;
    params.preset = preset;
    params.min_viewpoint_m2 = min_viewpoint_m2;
    return params;
  }
  static mapping::TsdfParams map_params() {
    mapping::TsdfParams params;
    params.voxel_m = 0.2;
    return params;
  }

  Ceiling ceiling_;
  ExplorationTargets targets_;
  mapping::TsdfMap map_;
  GridFreeSpace ground_{{0, 0}, {kLength, kWidth}, 0.1, [](const Eigen::Vector2d& p) {
                          return p.x() > 0.4 && p.y() > 0.4 && p.x() < kLength - 0.4 && p.y() < kWidth - 0.4;
                        }};
  Pose2 pose_;
};

class Exploration : public testing::TestWithParam<const char*> {};

TEST_P(Exploration, CompletesARoomAndEndsWithAReasonForAllThatIsLeft) {
  Robot robot(GetParam());
  const std::size_t at_first = robot.surface().size();
  Targets targets = robot.plan();
  EXPECT_FALSE(targets.clusters.empty());
  int rounds = 0;
  for (; !targets.clusters.empty() && rounds < 60; ++rounds) {
    for (const Cluster& cluster : targets.clusters) {
      EXPECT_GE(cluster.gain, 0);
      EXPECT_LE(cluster.gain, 1);
      for (const Viewpoint& viewpoint : cluster.viewpoints) robot.look(viewpoint.pose, std::max(viewpoint.looks, 2));
    }
    targets = robot.plan();
  }
  EXPECT_LT(rounds, 60) << "it must end";
  EXPECT_EQ(targets.remaining.size(), robot.surface().size());
  EXPECT_LT(robot.surface().size(), at_first / 2);
  for (const Certificate& certificate : targets.remaining) {
    EXPECT_TRUE(robot.surface().contains(certificate.element));
    if (std::string(GetParam()) == "default") {
      EXPECT_NE(certificate.verdict, Verdict::kCompletable);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Presets, Exploration, testing::Values("default", "thesis"));

struct Tally {
  std::set<std::tuple<int, int, int>> served;  ///< or excused
  std::size_t viewpoints = 0;
  std::size_t smallest = 1000000;  ///< elements of a viewpoint

  explicit Tally(const Targets& targets) {
    const auto add = [&](const VoxelIndex& v) { served.emplace(v.x(), v.y(), v.z()); };
    for (const Cluster& cluster : targets.clusters) {
      viewpoints += cluster.viewpoints.size();
      for (const Viewpoint& viewpoint : cluster.viewpoints) {
        smallest = std::min(smallest, viewpoint.elements.size());
        for (const VoxelIndex& v : viewpoint.elements) add(v);
      }
    }
    for (const Certificate& certificate : targets.remaining) add(certificate.element);
  }
};

TEST(ExplorationTargets, ServesOrExcusesEveryElementIfNoneMayWait) {
  Robot robot("default", 0);
  const Targets targets = robot.plan();
  const Tally tally(targets);
  EXPECT_GT(tally.smallest, 0U);
  EXPECT_EQ(tally.served.size(), targets.elements);
  EXPECT_EQ(targets.postponed, 0U);
  EXPECT_LT(tally.viewpoints, Tally(Robot("thesis").plan()).viewpoints);
}

TEST(ExplorationTargets, WaitWithWhatCompletesLittle) {
  const Targets all = Robot("default", 0).plan(), large = Robot("default", 0.5).plan();
  const Tally of_all(all), of_large(large);
  EXPECT_GT(large.postponed, 0U);
  EXPECT_EQ(of_large.served.size() + large.postponed, large.elements) << "each is served or waits";
  EXPECT_TRUE(large.remaining.empty()) << "nobody asked yet why the others stay";
  EXPECT_LT(of_large.viewpoints, of_all.viewpoints);
  // Nothing here completes 1000 m2, so nothing has to wait for such a viewpoint.
  EXPECT_FALSE(Robot("default", 1000).plan().clusters.empty());
}

/// Elements at the upper rim of the wall ahead, by verdict.
std::map<Verdict, int> rim_ahead(const Robot& robot) {
  std::map<Verdict, int> count;
  for (const Certificate& certificate : robot.certify()) {
    const Eigen::Vector3d p = (certificate.element.cast<double>().array() + 0.5) * 0.2;
    if (p.x() > kLength - 0.4 && std::abs(p.y() - 2) < 0.7 && p.z() > kHeight - 0.3) ++count[certificate.verdict];
  }
  return count;
}

TEST(ExplorationTargets, GiveUpARimBeforeTheSkyAfterSomeLooksThatSayNothing) {
  Robot robot("default", 0, Ceiling::kOpen), stubborn("default", 0, Ceiling::kOpen, 1e6);
  robot.look({2.2, 2, 0}, 2);
  EXPECT_GT(rim_ahead(robot)[Verdict::kCompletable], 0) << "it looks as if the wall went on";
  robot.look({2.2, 2, 0}, 7);
  stubborn.look({2.2, 2, 0}, 9);
  EXPECT_EQ(rim_ahead(robot)[Verdict::kCompletable], 0);
  EXPECT_GT(rim_ahead(robot)[Verdict::kBelowSensingLimit], 3);
  EXPECT_GT(rim_ahead(stubborn)[Verdict::kCompletable], 3);
}

TEST(ExplorationTargets, PlanTheSameFromTheSameHistoryAndKeepIds) {
  Robot one("default"), two("default");
  const Targets first = one.plan(), same = two.plan();
  ASSERT_EQ(first.clusters.size(), same.clusters.size());
  for (std::size_t i = 0; i < first.clusters.size(); ++i) {
    EXPECT_EQ(first.clusters[i].id, same.clusters[i].id);
    EXPECT_EQ(first.clusters[i].elements, same.clusters[i].elements);
    ASSERT_EQ(first.clusters[i].viewpoints.size(), same.clusters[i].viewpoints.size());
    for (std::size_t v = 0; v < first.clusters[i].viewpoints.size(); ++v) {
      EXPECT_EQ(first.clusters[i].viewpoints[v].pose, same.clusters[i].viewpoints[v].pose);
    }
  }
  const Targets again = one.plan();
  for (std::size_t i = 0; i < first.clusters.size(); ++i) EXPECT_EQ(again.clusters[i].id, first.clusters[i].id);
}

TEST(ExplorationTargets, RefuseParametersThatBreakTheirRules) {
  ViewpointParams params;
  params.d_v_m = -1;
  EXPECT_THROW(ExplorationTargets(params, LevelCamera{}), InputError);
}

}  // namespace
}  // namespace arpent::planning
