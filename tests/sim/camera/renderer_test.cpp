// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "common/error.h"
#include "tests/sim/camera/scenes.h"

namespace arpent::sim {
namespace {

const std::string kWorlds = ARPENT_SOURCE_DIR "/config/worlds/";

bool same(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF) == 0;
}

const Renderer& arena() {
  static const Renderer renderer(load_world(kWorlds + "test_arena.yaml"));
  return renderer;
}

/// Nearest of the arena's planes along a ray from inside, in double precision; 0 for the void above.
double arena_depth(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  double nearest = 1e9;
  const auto plane = [&](int axis, double at, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    const double t = (at - from[axis]) / ray[axis];
    const Eigen::Vector3d p = from + t * ray;
    for (int k = 0; k < 3; ++k) {
      if (k != axis && (p[k] < low[k] || p[k] > high[k])) return;
    }
    if (t > 0) nearest = std::min(nearest, t);
  };
  const Eigen::Vector3d hall0(0, 0, 0), hall1(8, 7, 2), box0(4.0, 3.1, 0), box1(4.8, 3.9, 2);
  plane(2, 0, hall0, hall1);
  for (int axis = 0; axis < 2; ++axis) {
    for (const double at : {hall0[axis], hall1[axis]}) plane(axis, at, hall0, hall1);
    for (const double at : {box0[axis], box1[axis]}) plane(axis, at, box0, box1);
  }
  plane(2, 2, box0, box1);
  // The tag cube and its stand.
  const Eigen::Vector3d cube0(2.05, 3.35, 0.25), cube1(2.35, 3.65, 0.55), stand0(2.18, 3.48, 0),
      stand1(2.22, 3.52, 0.25);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double at : {cube0[axis], cube1[axis]}) plane(axis, at, cube0, cube1);
    for (const double at : {stand0[axis], stand1[axis]}) plane(axis, at, stand0, stand1);
  }
  return nearest < 1e8 ? nearest : 0;
}

TEST(Renderer, DepthIsExactInTheArena) {
  const CameraModel camera(half_camera());
  int on_edges = 0, seen = 0;
  for (const double yaw : {0.0, 0.8, 2.5, -1.9}) {
    const Pose T = Pose2{1.5, 4.4, yaw}.to_pose() * looking_along_x({0.2, 0.13, 0.4});
    const cv::Mat1f depth = arena().render(camera, T, {}).depth_m;
    for (int v = 0; v < depth.rows; v += 3) {
      for (int u = 0; u < depth.cols; u += 3) {
        const Eigen::Vector3d ray = T.linear() * half_camera().pinhole.unproject(u, v, 1);
        const double expected = arena_depth(T.translation(), ray);
        seen += expected > 0 ? 1 : 0;
        // A ray that grazes an edge may fall on either side.
        if (std::abs(static_cast<double>(depth(v, u)) - expected) > 2e-5 * expected + 1e-5) ++on_edges;
      }
    }
  }
  EXPECT_GT(seen, 20000);
  EXPECT_LE(on_edges, 3);
}

TEST(Renderer, SameArgumentsSameBytesAlsoFromTwoThreadsAndTwoRenderers) {
  const CameraModel camera(half_camera());
  CameraShot shot;
  shot.seed = 4;
  shot.twist_cam << 0, 0, 0.5, 0, 1, 0;
  const std::vector<Body> bodies{{Pose2{3, 4, 1}.to_pose()}};
  const Pose T = Pose2{1.5, 3, 0.3}.to_pose() * looking_along_x({0, 0, 0.4});
  const CameraImage first = arena().render(camera, T, shot, bodies);
  CameraImage second, third;
  std::thread other([&] { second = arena().render(camera, T, shot, bodies); });
  third = Renderer(load_world(kWorlds + "test_arena.yaml")).render(camera, T, shot, bodies);
  other.join();
  EXPECT_TRUE(same(first.image, second.image) && same(first.depth_m, second.depth_m));
  EXPECT_TRUE(same(first.image, third.image) && same(first.depth_m, third.depth_m));
  EXPECT_TRUE(same(first.depth_m, arena().depth_m(camera, T, bodies)));
  ++shot.seed;
  EXPECT_FALSE(same(first.image, arena().render(camera, T, shot, bodies).image));
}

/// A wall's picture has its texture's mean and contrast.
TEST(Renderer, LevelsFollowReflectanceAndContrast) {
  TextureSpec texture = plain(0.40);
  texture.kind = "plaster";
  texture.contrast = 0.06;
  const Renderer renderer(wall_world(3, texture));
  const CameraModel camera(half_camera(), ideal());
  cv::Scalar mean, deviation;
  const cv::Mat1b image = renderer.render(camera, looking_along_x({0, 0, 0}), {}).image;
  cv::meanStdDev(image, mean, deviation);
  EXPECT_NEAR(mean[0], 0.40 * kLevelsPerRadiance, 4);
  // The pixel's footprint takes the finest grain away.
  EXPECT_NEAR(deviation[0], 0.06 * kLevelsPerRadiance, 4);
}

/// The same view at four times the resolution, averaged down, against the direct picture: what aliases would differ.
TEST(Renderer, TexturesDoNotAlias) {
  TextureSpec texture = plain(0.40);
  texture.kind = "asphalt";
  texture.contrast = 0.08;
  World world = wall_world(6, texture);
  world.surfaces.push_back({PlaneShape{{-1, -5, -0.6}, {7, 0, 0}, {0, 10, 0}}, 0, 0});  // a floor, seen at a slant
  const Renderer renderer(world);
  RawCamera small, large;
  small.pinhole = {160, 128, 94, 94, 79.5, 63.5};
  large.pinhole = {640, 512, 376, 376, 319.5, 255.5};
  const Pose T = looking_along_x({0, 0, 0});
  const auto picture = [&](const RawCamera& camera) {
    cv::Mat1f image;
    renderer.render(CameraModel(camera, ideal()), T, {}).image.convertTo(image, CV_32F);
    return image;
  };
  cv::Mat1f averaged;
  cv::resize(picture(large), averaged, cv::Size(160, 128), 0, 0, cv::INTER_AREA);
  const cv::Mat1f direct = picture(small);
  const auto rms = [](const cv::Mat1f& a) { return std::sqrt(cv::mean(a.mul(a))[0]); };
  for (const cv::Rect& part : {cv::Rect(8, 8, 144, 50), cv::Rect(8, 80, 144, 40)}) {
    cv::Scalar mean, deviation;
    cv::meanStdDev(averaged(part), mean, deviation);
    EXPECT_LT(rms(direct(part) - averaged(part)), 0.45 * deviation[0]) << part;
    cv::Scalar direct_mean, direct_deviation;
    cv::meanStdDev(direct(part), direct_mean, direct_deviation);
    EXPECT_NEAR(direct_mean[0], mean[0], 0.5);
    EXPECT_LT(direct_deviation[0], 1.15 * deviation[0]) << "aliases add contrast";
    EXPECT_GT(direct_deviation[0], 0.6 * deviation[0]) << "too much blur takes it away";
  }
}

/// Half a pixel of a bright box edge gives half its light.
TEST(Renderer, EdgesAreSmooth) {
  World world = wall_world(4, plain(0.2));
  world.textures.push_back(plain(0.8));
  world.surfaces.push_back({PlaneShape{{2, 0.003, -1}, {0, -1.003, 0}, {0, 0, 2}}, 1, 0});
  world.lighting.lamps.clear();
  world.lighting.ambient = 1;
  const Renderer renderer(world);
  const CameraModel camera(half_camera(), ideal());
  const cv::Mat1b image = renderer.render(camera, looking_along_x({0, 0, 0}), {}).image;
  // The edge y = 0.003 is at u = 159.5 - 188.5 0.0015 = 159.22: pixel 159 shows 0.28 of the bright plane.
  const double dark = image(128, 156), bright = image(128, 162);
  EXPECT_NEAR((image(128, 159) - dark) / (bright - dark), 0.28, 0.13);
  EXPECT_GT(bright, 2 * dark);
}

TEST(Renderer, TeammatesAreSeenWhereTheyAre) {
  const CameraModel camera(half_camera());
  const Pose T = Pose2{1.0, 6.0, 0}.to_pose() * looking_along_x({0, 0, 0.4});
  std::vector<Body> bodies;
  for (int i = 0; i < 7; ++i) bodies.push_back({Pose2{3.0 + 0.6 * i, 6.0 - 0.7 * i, 0.4 * i}.to_pose()});
  const CameraImage alone = arena().render(camera, T, {});
  const CameraImage team = arena().render(camera, T, {}, bodies);
  // The first stands 2 m ahead, its rear at x = 2.7: depth 1.7 m.
  EXPECT_NEAR(team.depth_m(150, 159), 1.7F, 1e-4F);
  EXPECT_GT(alone.depth_m(150, 159), 1.8F);
  EXPECT_GT(cv::countNonZero(alone.image != team.image), 2000);
  int nearer = 0;
  for (int v = 0; v < 256; ++v) {
    for (int u = 0; u < 320; ++u) {
      if (team.depth_m(v, u) == alone.depth_m(v, u)) continue;
      ++nearer;
      EXPECT_LT(team.depth_m(v, u), alone.depth_m(v, u) > 0 ? alone.depth_m(v, u) : 1e9F);
    }
  }
  EXPECT_GT(nearer, 2000);
}

TEST(Renderer, CornersOfTheParkingLotAreDarkAndItsEntranceBright) {
  const Renderer renderer(load_world(kWorlds + "parking_lot.yaml"));
  const Eigen::Vector3d down(0, 0, -1);
  double sum = 0, corners = 0;
  int count = 0;
  for (double x = 0.25; x < 21; x += 0.5) {
    for (double y = 0.25; y < 14; y += 0.5, ++count) sum += *renderer.irradiance({x, y, 0.02}, down);
  }
  for (const double x : {0.3, 20.7}) {
    for (const double y : {0.3, 13.7}) corners += *renderer.irradiance({x, y, 0.5}, down) / 4;
  }
  EXPECT_NEAR(corners / (sum / count), 0.15, 0.03);
  EXPECT_GT(*renderer.irradiance({20.3, 7, 0.5}, down), 1.2 * sum / count);
  const CameraModel camera(half_camera());
  const cv::Mat1b image = renderer.render(camera, looking_along_x({17.5, 6.4, 0.4}), {}).image;
  EXPECT_GT(cv::countNonZero(image == 255), 500) << "the tarpaulin outshines the sensor";
}

/// Mats are poor in texture, the floor and the obstacle are not: the share of pixels with a gradient that a matcher can
/// hold on to.
TEST(Renderer, TheArenaHasPoorWallsAndARichFloor) {
  const CameraModel camera(half_camera());
  const Pose T = Pose2{2.0, 1.5, 0.4}.to_pose() * looking_along_x({0, 0, 0.4});
  const CameraImage shot = arena().render(camera, T, {});
  const auto rich_share = [&](const cv::Rect& part) {
    int rich = 0;
    for (int v = part.y; v < part.br().y; ++v) {
      for (int u = part.x; u < part.br().x; ++u)
        rich += std::abs(shot.image(v, u + 1) - shot.image(v, u - 1)) > 8 ? 1 : 0;
    }
    return static_cast<double>(rich) / part.area();
  };
  EXPECT_LT(rich_share(cv::Rect(200, 95, 110, 30)), 0.15) << "wall";
  EXPECT_GT(rich_share(cv::Rect(10, 190, 300, 60)), 0.25) << "floor";
}

TEST(Renderer, ACameraThatCannotBeIsRefused) {
  RawCamera camera = half_camera();
  camera.pinhole.fx_px = 0;
  EXPECT_THROW(CameraModel{camera}, InputError);
  camera = half_camera();
  camera.pinhole.width_px = 1;
  camera.pinhole.cx_px = 0;
  EXPECT_THROW(CameraModel{camera}, InputError);
}

}  // namespace
}  // namespace arpent::sim
