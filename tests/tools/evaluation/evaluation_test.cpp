// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <random>

#include "common/error.h"
#include "tools/evaluation/mesh.h"
#include "tools/evaluation/surface_index.h"
#include "tools/evaluation/trajectory.h"

namespace arpent::evaluation {
namespace {

namespace fs = std::filesystem;

Trajectory wander(unsigned seed, int count) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Trajectory trajectory;
  Pose T = Pose::Identity();
  for (int i = 0; i < count; ++i) {
    trajectory.push_back({from_utime(100000LL * i), T});
    T = retract(T,
                (Vector6d() << 0.5, 0.1 * uniform(generator), 0.1 * uniform(generator), 0, 0, 0.2 * uniform(generator))
                    .finished());
  }
  return trajectory;
}

std::string path_of(const std::string& name) {
  return testing::TempDir() + "evaluation_" + name;
}

TEST(Trajectory, TumSurvivesTheRoundTripAndOtherFormatsAreTold) {
  const Trajectory trajectory = wander(1, 20);
  write_tum(path_of("a.tum"), trajectory);
  const Trajectory back = read_trajectory(path_of("a.tum"));
  ASSERT_EQ(back.size(), 20U);
  EXPECT_EQ(back[7].stamp, trajectory[7].stamp);
  EXPECT_TRUE(back[7].T_ref_body.isApprox(trajectory[7].T_ref_body, 1e-7));
  std::ofstream(path_of("k.txt")) << "1 0 0 1 0 1 0 2 0 0 1 3\n1 0 0 4 0 1 0 5 0 0 1 6\n";
  EXPECT_EQ(read_trajectory(path_of("k.txt"))[1].T_ref_body.translation(), Eigen::Vector3d(4, 5, 6));
  std::ofstream(path_of("e.csv")) << "#timestamp\n1500000000,1,2,3,0,1,0,0,9,9,9\n";
  const auto euroc = read_trajectory(path_of("e.csv"));
  EXPECT_EQ(to_utime(euroc[0].stamp), 1500000);
  EXPECT_TRUE(euroc[0].T_ref_body.linear().isApprox(
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix(), 1e-9))
      << "scalar first";
  for (const char* bad : {"1 2 3\n", "1 2 3 4 5 6 7 x\n", "0 0 0 0 9 9 9 9\n", "\n", "nan 0 0 0 0 0 0 1\n"}) {
    std::ofstream(path_of("bad")) << bad;
    EXPECT_THROW((void)read_trajectory(path_of("bad")), InputError) << bad;
  }
}

TEST(Trajectory, AlignmentRecoversAKnownMotion) {
  const Trajectory reference = wander(2, 50);
  Pose yawed(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()));
  yawed.translation() = Eigen::Vector3d(3, -2, 1);
  const Pose tilted = yawed * Pose(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 0).normalized()));
  const auto moved = [&](const Pose& T) {
    Trajectory estimate = reference;
    for (auto& pose : estimate) pose.T_ref_body = T * pose.T_ref_body;
    return estimate;
  };
  EXPECT_LT(evaluate(reference, moved(tilted), Alignment::kSe3).ate_m.max, 1e-9);
  EXPECT_LT(evaluate(reference, moved(yawed), Alignment::kPosYaw).ate_m.max, 1e-9);
  EXPECT_GT(evaluate(reference, moved(tilted), Alignment::kPosYaw).ate_m.max, 0.1);
  EXPECT_GT(evaluate(reference, moved(yawed), Alignment::kNone).ate_m.rmse, 1.0);
}

TEST(Trajectory, ErrorsAreThoseComputedByHand) {
  // A straight metre a step; the estimate is 1 % too long: each segment of 10 m errs by 0.1 m, 1 %, and the step by 1
  // cm.
  Trajectory reference, estimate;
  for (int i = 0; i <= 60; ++i) {
    Pose T = Pose::Identity();
    T.translation().x() = i;
    reference.push_back({from_utime(100000LL * i), T});
    T.translation().x() = 1.01 * i;
    estimate.push_back({from_utime(100000LL * i + 3000), T});
  }
  const auto errors = evaluate(reference, estimate, Alignment::kNone);
  EXPECT_EQ(errors.poses, 61);
  EXPECT_NEAR(errors.path_m, 60, 1e-9);
  EXPECT_NEAR(errors.segments.t_rel_percent, 1.0, 1e-6);
  EXPECT_NEAR(errors.end_error_percent, 1.0, 1e-9);
  EXPECT_NEAR(errors.rpe_m.rmse, 0.01, 1e-9);
  EXPECT_NEAR(errors.ate_m.max, 0.6, 1e-9);
  EXPECT_NEAR(errors.ate_m.mean, 0.3, 1e-9);
}

TEST(Trajectory, PosesAreAssociatedWithinTenMilliseconds) {
  const Trajectory reference = wander(3, 10);
  Trajectory late = reference;
  for (auto& pose : late) pose.stamp += std::chrono::milliseconds(11);
  EXPECT_TRUE(associate(reference, late).estimate.empty());
  EXPECT_THROW((void)evaluate(reference, late, Alignment::kSe3), InputError);
  for (auto& pose : late) pose.stamp -= std::chrono::milliseconds(2);
  EXPECT_EQ(associate(reference, late).estimate.size(), 10U);
}

TriangleMesh square(double z, double side) {
  const auto h = static_cast<float>(side / 2), f = static_cast<float>(z);
  TriangleMesh mesh;
  mesh.vertices_m = {{-h, -h, f}, {h, -h, f}, {h, h, f}, {-h, h, f}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST(MeshErrors, AParallelPlaneIsOffByItsDistance) {
  for (const double offset : {0.02, -0.03}) {
    MeshParams params;
    params.samples_per_m2 = 2000;
    const MeshErrors errors = evaluate_mesh(square(0, 3), square(offset, 3), params);
    EXPECT_NEAR(errors.coverage_percent, 100, 1e-9);
    EXPECT_NEAR(errors.mean_cm, 100 * offset, 0.01);
    EXPECT_NEAR(errors.rmse_cm, 100 * std::abs(offset), 0.01);
    EXPECT_NEAR(errors.accuracy_rmse_cm, 100 * std::abs(offset), 0.01);
    EXPECT_GT(errors.m3c2_points, 10000);
  }
}

TEST(MeshErrors, CoverageIsTheShareWithinTheBound) {
  MeshParams params;
  params.e_max_m = 0.1;
  EXPECT_NEAR(evaluate_mesh(square(0, 3), square(0.11, 3), params).coverage_percent, 0, 1e-9);
  // Half the side: a quarter of the area and the rim of 0.1 m around it.
  const double expected = 100 * (1.5 * 1.5 + 4 * 1.5 * 0.1 + std::numbers::pi * 0.01) / 9;
  EXPECT_NEAR(evaluate_mesh(square(0, 3), square(0, 1.5), params).coverage_percent, expected, 0.7);
  EXPECT_THROW((void)evaluate_mesh(TriangleMesh{}, square(0, 1), params), InputError);
}

TEST(MeshErrors, DistanceToATriangleIsThatOfItsNearestPoint) {
  std::mt19937 generator(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto random = [&] { return Eigen::Vector3d(uniform(generator), uniform(generator), uniform(generator)); };
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d a = random(), b = random(), c = random(), p = 2 * random();
    double nearest = 1e9;
    for (int u = 0; u <= 200; ++u) {
      for (int v = 0; u + v <= 200; ++v)
        nearest = std::min(nearest, (a + u / 200.0 * (b - a) + v / 200.0 * (c - a) - p).norm());
    }
    EXPECT_NEAR(point_triangle_distance(p, a, b, c), nearest, 0.01);
    EXPECT_LE(point_triangle_distance(p, a, b, c), nearest + 1e-12);
  }
}

TEST(Ply, SurvivesTheRoundTripAndReadsText) {
  TriangleMesh mesh = square(1, 2);
  mesh.normals.assign(4, Eigen::Vector3f::UnitZ());
  mesh.colors_rgb.assign(4, {1, 2, 3});
  write_ply(path_of("m.ply"), mesh);
  const TriangleMesh back = read_ply(path_of("m.ply"));
  EXPECT_EQ(back.vertices_m, mesh.vertices_m);
  EXPECT_EQ(back.normals, mesh.normals);
  EXPECT_EQ(back.colors_rgb, mesh.colors_rgb);
  EXPECT_EQ(back.triangles, mesh.triangles);
  std::ofstream(path_of("t.ply")) << "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double "
                                     "y\nproperty double z\nproperty int extra\n"
                                     "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 7\n1 0 "
                                     "0 7\n1 1 0 7\n0 1 0 7\n4 0 1 2 3\n";
  const TriangleMesh text = read_ply(path_of("t.ply"));
  EXPECT_EQ(text.vertices_m[2], Eigen::Vector3f(1, 1, 0));
  EXPECT_EQ(text.triangles.size(), 2U) << "a quad is two triangles";
}

TEST(Ply, DamageIsAnErrorOrAMeshNeverACrash) {
  write_ply(path_of("m.ply"), square(1, 2));
  std::ifstream in(path_of("m.ply"), std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  const auto judge = [&](const std::string& damaged) {
    std::ofstream(path_of("d.ply"), std::ios::binary) << damaged;
    try {
      (void)read_ply(path_of("d.ply"));
    } catch (const InputError&) {
    }
  };
  for (std::size_t at = 0; at < whole.size(); ++at) {
    judge(whole.substr(0, at));
    for (const char c : {'\xff', '9', '\0'}) {
      std::string damaged = whole;
      damaged[at] = c;
      judge(damaged);
    }
  }
  EXPECT_THROW((void)read_ply("/no/such.ply"), InputError);
}

TEST(MeshErrors, CloudCompareMeasuresTheSameDistance) {
  if (std::system("command -v CloudCompare >/dev/null") != 0) GTEST_SKIP() << "CloudCompare is not installed";
  const std::string folder = path_of("cc");
  fs::create_directories(folder);
  TriangleMesh a, b;
  std::mt19937 generator(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (int i = 0; i < 5000; ++i) {
    a.vertices_m.emplace_back(uniform(generator), uniform(generator), 0.1F * uniform(generator));
    b.vertices_m.emplace_back(uniform(generator), uniform(generator), 0.1F * uniform(generator));
  }
  write_ply(folder + "/a.ply", a);
  write_ply(folder + "/b.ply", b);
  const std::string command =
      "cd " + folder +
      " && QT_QPA_PLATFORM=offscreen timeout 60 CloudCompare -SILENT -AUTO_SAVE OFF -O a.ply -O b.ply -C2C_DIST 2>&1 | "
      "grep -o 'Mean distance = [0-9.]*' | grep -o '[0-9.]*$' >mean.txt";
  (void)std::system(command.c_str());
  double theirs = 0;
  if (!(std::ifstream(folder + "/mean.txt") >> theirs)) GTEST_SKIP() << "CloudCompare printed no mean distance";
  double mean = 0;
  for (const auto& p : a.vertices_m) {
    float nearest = 1e9F;
    for (const auto& q : b.vertices_m) nearest = std::min(nearest, (p - q).squaredNorm());
    mean += std::sqrt(nearest) / 5000.0;
  }
  EXPECT_NEAR(theirs, mean, 0.02 * mean) << "the oracle itself";
  MeshParams params;
  params.e_max_m = 1.0;
  const MeshErrors errors = evaluate_mesh(b, a, params);  // accuracy: the estimate's points to the reference
  double squares = 0;
  for (const auto& p : a.vertices_m) {
    float nearest = 1e9F;
    for (const auto& q : b.vertices_m) nearest = std::min(nearest, (p - q).squaredNorm());
    squares += nearest / 5000.0;
  }
  EXPECT_NEAR(errors.accuracy_rmse_cm, 100 * std::sqrt(squares), 1e-3);
}

}  // namespace
}  // namespace arpent::evaluation
