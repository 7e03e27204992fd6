// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "common/error.h"
#include "sim/world/world.h"

namespace arpent::sim {
namespace {

const std::string kWorlds = ARPENT_SOURCE_DIR "/config/worlds/";

/// A sound world: lines 1 to 13.
const std::string kSmall = R"(name: small
region: {min_m: [0, 0, 0], max_m: [6, 5, 2]}
textures:
  floor: {kind: asphalt, mean: 0.3, contrast: 0.05}
surfaces:
  - plane: {corner_m: [0, 0, 0], u_m: [6, 0, 0], v_m: [0, 5, 0], texture: floor}
  - box: {centre_m: [4, 2.5, 0.5], size_m: [1, 1, 1], yaw_rad: 0.2, texture: floor}
lighting:
  lamps:
    - {position_m: [3, 3, 1.9]}
starts:
  - {x_m: 1, y_m: 1, yaw_rad: 0}
  - {x_m: 1, y_m: 3, yaw_rad: 0}
)";

std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string fault_of(const std::string& yaml) {
  try {
    (void)parse_world(yaml, "w.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(WorldFile, ReadsWhatItWrites) {
  const World world = parse_world(kSmall, "w.yaml");
  EXPECT_EQ(world.surfaces.size(), 2U);
  EXPECT_EQ(std::get<BoxShape>(world.surfaces[1].shape).yaw_rad, 0.2);
  EXPECT_EQ(to_yaml(parse_world(to_yaml(world), "again")), to_yaml(world));
}

TEST(WorldFile, EveryFaultIsNamedWithItsLineInOneGo) {
  std::string yaml = with(kSmall, "mean: 0.3", "mean: .nan");
  yaml = with(yaml, "kind: asphalt", "kind: velvet");
  yaml = with(yaml, "size_m: [1, 1, 1]", "size_m: [1, 1, 0]");
  yaml = with(yaml, "v_m: [0, 5, 0], texture: floor", "v_m: [0, 5, 0], texture: carpet");
  yaml = with(yaml, "yaw_rad: 0}\n  - ", "yaw: 0}\n  - ");
  const std::string faults = fault_of(yaml);
  EXPECT_THAT(faults, testing::HasSubstr("w.yaml:4: texture floor: mean must be a finite number"));
  EXPECT_THAT(faults, testing::HasSubstr("w.yaml:4: texture floor: kind = velvet, must be one of"));
  EXPECT_THAT(faults, testing::HasSubstr("w.yaml:6: plane: there is no texture carpet"));
  EXPECT_THAT(faults, testing::HasSubstr("w.yaml:7: box: size_m must be > 0"));
  EXPECT_THAT(faults, testing::HasSubstr("w.yaml:12: start: missing key yaw_rad"));
  EXPECT_THAT(faults, testing::HasSubstr("w.yaml:12: start: unknown key yaw"));
}

TEST(WorldFile, StartsMustBeFreeApartAndInTheRegion) {
  EXPECT_THAT(fault_of(with(kSmall, "x_m: 1, y_m: 1", "x_m: 4, y_m: 2.5")),
              testing::HasSubstr("w.yaml:12: start 0 at (4, 2.5) touches an obstacle"));
  EXPECT_THAT(fault_of(with(kSmall, "y_m: 3", "y_m: 1.4")),
              testing::HasSubstr("w.yaml:13: start 1 at (1, 1.4) touches start 0 (line 12)"));
  EXPECT_EQ(fault_of(with(kSmall, "y_m: 3", "y_m: 1.51")), "") << "side by side: 0.5 m between them";
  EXPECT_THAT(fault_of(with(kSmall, "x_m: 1, y_m: 3", "x_m: 7, y_m: 3")),
              testing::HasSubstr("w.yaml:13: start 1 at (7, 3) is outside the region"));
}

TEST(WorldFile, ATagCubeStandsFreeAndHasTagsOfTheFamily) {
  EXPECT_EQ(fault_of(kSmall + "tag_cube: {centre_m: [2.5, 2.5, 0.4]}\n"), "");
  EXPECT_THAT(fault_of(kSmall + "tag_cube: {centre_m: [3.5, 2.5, 0.4]}\n"), testing::HasSubstr("touches an obstacle"));
  EXPECT_THAT(fault_of(kSmall + "tag_cube: {centre_m: [2.5, 2.5, 0.4], ids: [0, 1, 2, 587]}\n"),
              testing::HasSubstr("w.yaml:14: tag_cube: ids must be tags of 36h11, 0 to 586"));
}

TEST(WorldFile, AMissingMeshIsNamed) {
  const std::string yaml = with(kSmall, "  - box: {centre_m: [4, 2.5, 0.5], size_m: [1, 1, 1], yaw_rad: 0.2,",
                                "  - mesh: {file: /nowhere/thing.obj,");
  EXPECT_THAT(fault_of(yaml), testing::StartsWith("w.yaml:7: mesh /nowhere/thing.obj: is not there"));
}

TEST(WorldFile, NoYamlAndNoFileGiveOneLine) {
  EXPECT_THAT(fault_of("name: [\n"), testing::StartsWith("w.yaml:2: not valid YAML"));
  EXPECT_THAT(fault_of("- 1\n"), testing::HasSubstr("w.yaml:1: world: must be a group of keys"));
  EXPECT_THAT(fault_of(""), testing::HasSubstr("must be a group of keys"));
  EXPECT_THROW((void)load_world("/nowhere/w.yaml"), InputError);
  EXPECT_THROW((void)load_world("/tmp"), InputError);
}

/// The numbers of the design.
TEST(WorldFile, TheReferenceWorldsAreTheAgreedOnes) {
  const World arena = load_world(kWorlds + "test_arena.yaml");
  EXPECT_EQ(arena.starts, (std::vector<Pose2>{{1.0, 3.5, 0}, {1.0, 2.4, 0.7}, {1.0, 4.6, -0.7}}));
  EXPECT_EQ(arena.region.max_m, Eigen::Vector3d(8, 7, 2));
  EXPECT_EQ(arena.tag_cube->centre_m, Eigen::Vector3d(2.2, 3.5, 0.40));
  const World lot = load_world(kWorlds + "parking_lot.yaml");
  EXPECT_EQ(lot.starts, (std::vector<Pose2>{
                            {1.2, 7.0, 0}, {1.2, 8.4, -0.57}, {1.2, 5.6, 0.57}, {2.6, 9.2, -1.22}, {2.6, 4.8, 1.22}}));
  EXPECT_EQ(lot.region.max_m, Eigen::Vector3d(21, 14, 2));
  EXPECT_EQ(lot.tag_cube->centre_m, Eigen::Vector3d(3.4, 7.0, 0.40));
  int boxes = 0;
  for (const WorldSurface& surface : lot.surfaces) boxes += std::holds_alternative<BoxShape>(surface.shape) ? 1 : 0;
  EXPECT_EQ(boxes, 3 + 8) << "pillars and boxes";
}

TEST(WorldFile, TheMeshWorldsLoad) {
  for (const std::string name : {"small_warehouse", "parking_garage", "powerplant", "statue_of_liberty"}) {
    if (std::getenv("ARPENT_DATA") == nullptr) {
      try {
        (void)load_world(kWorlds + name + ".yaml");
        ADD_FAILURE() << name;
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("set ARPENT_DATA"));
      }
    } else {
      EXPECT_GE(load_world(kWorlds + name + ".yaml").starts.size(), 3U) << name;
    }
  }
  if (std::getenv("ARPENT_DATA") == nullptr) GTEST_SKIP() << "ARPENT_DATA is not set";
}

/// Two triangles back to back, one with a picture: SketchUp's habit.
TEST(WorldFile, TwinTrianglesAreKeptOnce) {
  const std::string folder = testing::TempDir();
  const std::string obj = folder + "/twins.obj";
  FILE* file = std::fopen(obj.c_str(), "w");
  std::fputs("v 2 2 0\nv 3 2 0\nv 3 3 1\nf 1 2 3\nf 3 2 1\nf 1 3 2\n", file);
  std::fclose(file);
  const World world = parse_world(with(kSmall, "  - box: {centre_m: [4, 2.5, 0.5], size_m: [1, 1, 1], yaw_rad: 0.2,",
                                       "  - mesh: {file: " + obj + ", scale: 0.5, translation_m: [2, 0, 0],"),
                                  "w.yaml");
  const auto& data = *std::get<MeshShape>(world.surfaces[1].shape).data;
  ASSERT_EQ(data.mesh.triangles.size(), 1U);
  EXPECT_EQ(data.mesh.vertices_m[0], Eigen::Vector3f(3, 1, 0)) << "scaled, then moved";
}

}  // namespace
}  // namespace arpent::sim
