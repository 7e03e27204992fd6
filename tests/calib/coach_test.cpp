// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/coach.h"

#include <gmock/gmock.h>

#include <numeric>

#include "calib/stereo.h"
#include "tests/calib/simulated_views.h"

namespace arpent::calib {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

const std::vector<CameraInput> kCameras{{"cam0", 1280, 1024}, {"cam1", 1280, 1024}};

/// The view that the rig has of a board turned by `turn` about the camera's axes, at a place in the left image.
View view_of(const Eigen::Vector3d& turn, const Eigen::Vector3d& place_m) {
  const RigEstimate rig = simulated_rig(DistortionModel::kRadialTangential);
  const Target target;
  const Eigen::Vector2d middle_m = 0.5 * target.size_m();
  Pose T = Pose::Identity();
  T.linear() = so3_exp(turn) * so3_exp({M_PI, 0, 0});
  T.translation() = place_m - T.linear() * Eigen::Vector3d(middle_m.x(), middle_m.y(), 0);
  View view{"v", {{}, {}}};
  for (std::size_t c = 0; c < 2; ++c) {
    for (int i = 0; i < target.corner_count(); ++i) {
      const Eigen::Vector2d b = target.corner_m(i);
      const Eigen::Vector3d p = rig.T_cam_first[c] * T * Eigen::Vector3d(b.x(), b.y(), 0);
      const LensParameters lens = to_parameters(rig.cameras[c]);
      Eigen::Vector2d px;
      if (!project(rig.cameras[c].distortion, lens.data(), p.data(), px.data())) continue;
      if (px.x() > 0 && px.y() > 0 && px.x() < 1280 && px.y() < 1024) view.cameras[c].push_back({i, px});
    }
  }
  return view;
}

TEST(CaptureCoach, TakesAViewThatIsHeldStillAndNotTwice) {
  CaptureCoach coach(Target{}, kCameras);
  EXPECT_EQ(coach.offer({"empty", {{}, {}}}), "no board in sight");
  const View view = view_of({0, 0, 0}, {0.1, 0, 1});
  EXPECT_EQ(coach.offer(view), "hold it still") << "nobody knows yet whether it is";
  EXPECT_THAT(coach.offer(view), HasSubstr("view 1 taken (facing the camera)"));
  EXPECT_THAT(coach.offer(view), Not(HasSubstr("taken")));
  EXPECT_EQ(coach.offer(view_of({0, 0, 0}, {0.16, 0, 1})), "hold it still");
  EXPECT_EQ(coach.views().views.size(), 1U);
}

TEST(CaptureCoach, TellsTheTiltsApart) {
  const auto tilt_of = [](const Eigen::Vector3d& turn) {
    CaptureCoach coach(Target{}, kCameras);
    const View view = view_of(turn, {0.1, 0, 1});
    (void)coach.offer(view);
    return coach.offer(view);
  };
  // x right, y down, z ahead: a positive turn about y takes the right edge nearer, one about x the lower edge away.
  EXPECT_THAT(tilt_of({0, 0.5, 0}), HasSubstr("(left edge away)"));
  EXPECT_THAT(tilt_of({0, -0.5, 0}), HasSubstr("(right edge away)"));
  EXPECT_THAT(tilt_of({0.5, 0, 0}), HasSubstr("(lower edge away)"));
  EXPECT_THAT(tilt_of({-0.5, 0, 0}), HasSubstr("(upper edge away)"));
  EXPECT_THAT(tilt_of({0, 0, 0.5}), HasSubstr("(facing the camera)"));
}

TEST(CaptureCoach, AsksForThePartThatIsEmptyAndTheTiltThatIsMissing) {
  CaptureCoach coach(Target{}, kCameras);
  for (const double x_m : {0.0, 0.3, 0.6}) {
    for (const double y_m : {0.0, 0.3}) {
      const View view = view_of({0, 0, 0}, {x_m, y_m, 1});
      (void)coach.offer(view);
      (void)coach.offer(view);
    }
  }
  EXPECT_EQ(coach.views().views.size(), 6U);
  const auto missing = coach.missing();
  EXPECT_THAT(missing.front(), HasSubstr("show it in the upper left of cam0"));
  for (const char* tilt : {"left edge away (0 of 3", "right edge away", "upper edge away", "lower edge away"}) {
    EXPECT_THAT(missing, Contains(HasSubstr(tilt)));
  }
  EXPECT_THAT(missing, Not(Contains(testing::StartsWith("facing"))));
  EXPECT_FALSE(coach.complete());
}

TEST(CaptureCoach, IsContentWithViewsThatMakeAGoodCalibration) {
  SimulationOptions options;
  options.views = 60;
  const RigEstimate rig = simulated_rig(DistortionModel::kRadialTangential);
  CaptureCoach coach(Target{}, kCameras);
  std::string last;
  for (const View& view : simulate_views(rig, options, 3).views) {
    (void)coach.offer(view);
    last = coach.offer(view);
    if (coach.complete()) break;
  }
  ASSERT_TRUE(coach.complete()) << testing::PrintToString(coach.missing());
  EXPECT_THAT(last, HasSubstr("next: complete"));
  EXPECT_GE(coach.views().views.size(), 20U);
  EXPECT_GE(coach.coverage_percent(1), 70);
}

}  // namespace
}  // namespace arpent::calib
