// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/certificate_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "common/error.h"

namespace arpent::planning {
namespace {

std::string file_of(const std::string& name) {
  return testing::TempDir() + "certificate_" + name + ".json";
}

/// Every field another value.
CertificateContext context() {
  CertificateContext c{.end = "aborted",
                       .reason = "too long",
                       .map_frame = "odom",
                       .voxel_m = 0.2,
                       .known_weight = 0.35,
                       .give_up_factor = 3,
                       .least_piece_m = 0.4,
                       .start = {1, 2, 0.5},
                       .semi_long_m = 0.6,
                       .semi_short_m = 0.3,
                       .lattice_m = 0.5};
  c.camera = {.left_slope = 0.81,
              .right_slope = 0.82,
              .up_slope = 0.61,
              .down_slope = 0.62,
              .baseline_m = 0.27,
              .min_range_m = 0.4,
              .max_range_m = 4.5,
              .p_body_m = {0.2, 0.13, 0.41}};
  for (const int h : {0, 5, 6, 11})
    c.poses.push_back({-1.5, 2.0, wrap_angle(2 * std::numbers::pi * h / Certifier::kHeadings)});
  c.poses.push_back({3.0, 2.5, wrap_angle(2 * std::numbers::pi * 3 / Certifier::kHeadings)});
  return c;
}

TEST(CertificateFile, ReadsBackWhatWasWritten) {
  const CertificateContext c = context();
  write_certificates(file_of("round"), c,
                     {{{1, -2, 3}, Verdict::kOccluded, {}, {0.3, 0.4, 0.5}, 17, 4, true},
                      {{4, 5, 6}, Verdict::kCompletable, {{1, 2, 3}}},
                      {{7, 8, 9}, Verdict::kOutOfRange, {}, {0.1, 0.2, 3.9}}});
  const CertificateFile file = read_certificates(file_of("round"));
  EXPECT_EQ(file.context.end, c.end);
  EXPECT_EQ(file.context.reason, c.reason);
  EXPECT_EQ(file.context.map_frame, c.map_frame);
  EXPECT_EQ(file.context.voxel_m, c.voxel_m);
  EXPECT_EQ(file.context.known_weight, c.known_weight);
  EXPECT_EQ(file.context.give_up_factor, c.give_up_factor);
  EXPECT_EQ(file.context.least_piece_m, c.least_piece_m);
  EXPECT_EQ(file.context.start, c.start);
  EXPECT_EQ(file.context.semi_long_m, c.semi_long_m);
  EXPECT_EQ(file.context.semi_short_m, c.semi_short_m);
  EXPECT_EQ(file.context.lattice_m, c.lattice_m);
  const LevelCamera &a = file.context.camera, &b = c.camera;
  EXPECT_EQ((std::array{a.left_slope, a.right_slope, a.up_slope, a.down_slope, a.baseline_m, a.min_range_m,
                        a.max_range_m, a.p_body_m.x(), a.p_body_m.y(), a.p_body_m.z()}),
            (std::array{b.left_slope, b.right_slope, b.up_slope, b.down_slope, b.baseline_m, b.min_range_m,
                        b.max_range_m, b.p_body_m.x(), b.p_body_m.y(), b.p_body_m.z()}));
  ASSERT_EQ(file.context.poses.size(), c.poses.size());
  for (std::size_t i = 0; i < c.poses.size(); ++i) {
    EXPECT_EQ(file.context.poses[i].position_m(), c.poses[i].position_m());
    EXPECT_NEAR(wrap_angle(file.context.poses[i].yaw_rad - c.poses[i].yaw_rad), 0, 1e-12);
  }
  ASSERT_EQ(file.elements.size(), 3U);
  EXPECT_EQ(file.elements[0].voxel, VoxelIndex(1, -2, 3));
  EXPECT_EQ(file.elements[0].verdict, Verdict::kOccluded);
  EXPECT_EQ(file.elements[0].place_m, Eigen::Vector3d(0.3, 0.4, 0.5));
  EXPECT_EQ(file.elements[0].in_view, 17);
  EXPECT_EQ(file.elements[0].in_sight, 4);
  EXPECT_TRUE(file.elements[0].small_piece);
  EXPECT_FALSE(file.elements[1].small_piece);
  EXPECT_TRUE(file.elements[1].place_m.isApprox(Eigen::Vector3d(0.9, 1.1, 1.3))) << "its own centre";
  EXPECT_EQ(file.elements[2].verdict, Verdict::kOutOfRange);
}

TEST(CertificateFile, NamesTheFileThatIsDamaged) {
  write_certificates(file_of("good"), context(), {{{1, 2, 3}, Verdict::kOccluded}});
  std::ostringstream good;
  good << std::ifstream(file_of("good")).rdbuf();
  const auto broken = [&](const std::string& from, const std::string& to) {
    std::string text = good.str();
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    std::ofstream(file_of("bad")) << text.replace(at, from.size(), to);
  };
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"arpent certificate 1", "arpent certificate 2"},
                                 {"occluded", "tired"},
                                 {"\"voxel_m\":0.2", "\"voxel_m\":-1"},
                                 {"\"camera\"", "\"kamera\""},
                                 {"{\"format\"", "\"format\""}}) {
    broken(from, to);
    try {
      (void)read_certificates(file_of("bad"));
      ADD_FAILURE() << to;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("bad.json"), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW((void)read_certificates(file_of("none")), InputError);
}

}  // namespace
}  // namespace arpent::planning
