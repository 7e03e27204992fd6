// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent world`: check a simulated world, look at it, draw a random one.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <opencv2/core.hpp>

#include "common/atomic_file.h"
#include "common/error.h"
#include "sim/world/random_world.h"
#include "tools/world/pictures.h"

namespace {

using namespace arpent;

struct Flags {
  std::string world;
  std::string out;
  std::string rig = "config/rigs/wifibot_stereo.yaml";
  std::vector<double> pose;
  int start = 0;
  int seed = 1;
};

int check(const Flags& flags) {
  const sim::World world = sim::load_world(flags.world);
  const TriangleMesh truth = sim::truth_mesh(world);
  double area_m2 = 0;
  for (const auto& t : truth.triangles) {
    const auto& v = truth.vertices_m;
    area_m2 += 0.5 * static_cast<double>((v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm());
  }
  std::printf("%s: sound; %zu surfaces, %zu starts, %.1f m2 to reconstruct\n", world.name.c_str(),
              world.surfaces.size(), world.starts.size(), area_m2);
  return 0;
}

int render(const Flags& flags) {
  const sim::World world = sim::load_world(flags.world);
  const Rig rig = load_rig(flags.rig);
  Pose2 pose = sim::start_of(world, flags.start);
  if (!flags.pose.empty()) pose = {flags.pose[0], flags.pose[1], flags.pose[2]};
  tools::write_pictures(tools::draw_world(world, rig, pose), flags.out);
  std::printf("%s\n", flags.out.c_str());
  return 0;
}

int draw(const Flags& flags) {
  const std::string yaml = sim::to_yaml(sim::make_random_world(static_cast<std::uint32_t>(flags.seed)));
  atomic_write(flags.out, "# Drawn by ./arpent world random --seed " + std::to_string(flags.seed) + "\n" + yaml);
  std::printf("%s\n", flags.out.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Simulated worlds (docs/worlds.md)."};
  app.name("arpent world");
  app.require_subcommand(1);
  Flags flags;
  CLI::App* checking = app.add_subcommand("check", "list every fault of a world");
  checking->add_option("FILE", flags.world, "world (config/worlds)")->required();
  CLI::App* rendering = app.add_subcommand("render", "what a robot sees, and the floor plan");
  rendering->add_option("FILE", flags.world, "world (config/worlds)")->required();
  rendering->add_option("--pose", flags.pose, "x,y,yaw of the robot [m, m, rad]")->delimiter(',')->expected(3);
  rendering->add_option("--start", flags.start, "or the number of a start")->capture_default_str();
  rendering->add_option("--rig", flags.rig, "the robot's cameras")->capture_default_str();
  rendering->add_option("--out", flags.out, "folder for left.png, right.png, depth.png, top.png; or one PNG")
      ->required();
  CLI::App* drawing = app.add_subcommand("random", "draw a world");
  drawing->add_option("--seed", flags.seed, "the same seed draws the same world")
      ->required()
      ->check(CLI::NonNegativeNumber);
  drawing->add_option("--out", flags.out, "world file to write")->required();
  try {
    app.parse(argc, argv);
    cv::setNumThreads(1);
    return checking->parsed() ? check(flags) : rendering->parsed() ? render(flags) : draw(flags);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "world: %s\n", error.what());
    return 2;
  }
}
