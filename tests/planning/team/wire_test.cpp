// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/team/wire.h"

#include <gtest/gtest.h>

#include <limits>

namespace arpent::planning {
namespace {

RobotState some_state() {
  RobotState state;
  state.stamp = from_utime(1234567);
  state.robot = "R2";
  state.state = MissionState::kRunning;
  state.body = {1, 2, 3};
  state.twist = {0.4, -0.5};
  state.position_sigma_m = 0.06;
  state.tour = 7;
  state.idle = false;
  state.target = Pose2{8, 9, 1};
  state.blocked_by = "R1";
  state.path_m = {{10, 11}, {12, 13}};
  return state;
}

TEST(TeamWire, EveryFieldOfARobotsStateSurvives) {
  const RobotState state = some_state();
  const auto back = from_wire(to_wire(state));
  ASSERT_TRUE(back) << back.fault();
  EXPECT_EQ(back->stamp, state.stamp);
  EXPECT_EQ(back->robot, "R2");
  EXPECT_EQ(back->state, state.state);
  EXPECT_EQ(back->body, state.body);
  EXPECT_EQ(back->twist.speed_mps, 0.4);
  EXPECT_EQ(back->twist.turn_rate_radps, -0.5);
  EXPECT_EQ(back->position_sigma_m, 0.06);
  EXPECT_EQ(back->tour, 7);
  EXPECT_FALSE(back->idle);
  EXPECT_EQ(back->target, state.target);
  EXPECT_EQ(back->blocked_by, "R1");
  EXPECT_EQ(back->path_m, state.path_m);
}

TEST(TeamWire, EveryFieldOfATourSurvives) {
  TeamTour tour;
  tour.stamp = from_utime(1);
  tour.number = 2;
  tour.robot = "R3";
  tour.state_stamp = from_utime(4);
  tour.valid_s = 5;
  tour.done = true;
  tour.viewpoints = {{{6, 7, 0.8}, {{9, -10, 11}, {12, 13, -14}}, 15}, {{1, 1, 1}, {}, 1}};
  const auto back = from_wire(to_wire(tour));
  ASSERT_TRUE(back) << back.fault();
  EXPECT_EQ(back->stamp, tour.stamp);
  EXPECT_EQ(back->number, 2);
  EXPECT_EQ(back->robot, "R3");
  EXPECT_EQ(back->state_stamp, tour.state_stamp);
  EXPECT_EQ(back->valid_s, 5);
  EXPECT_TRUE(back->done);
  ASSERT_EQ(back->viewpoints.size(), 2U);
  EXPECT_EQ(back->viewpoints[0].pose, tour.viewpoints[0].pose);
  EXPECT_EQ(back->viewpoints[0].elements, tour.viewpoints[0].elements);
  EXPECT_EQ(back->viewpoints[0].looks, 15);
  EXPECT_TRUE(back->viewpoints[1].elements.empty());
}

TEST(TeamWire, EveryFieldOfAReportSurvives) {
  const TourReport report{from_utime(5), "R4", {TargetEvent::Kind::kUnreachable, {1, 2, 0.5}}};
  const auto back = from_wire(to_wire(report));
  ASSERT_TRUE(back) << back.fault();
  EXPECT_EQ(back->stamp, report.stamp);
  EXPECT_EQ(back->robot, "R4");
  EXPECT_EQ(back->event.kind, TargetEvent::Kind::kUnreachable);
  EXPECT_EQ(back->event.target, report.event.target);
}

TEST(TeamWire, WhatCannotBeIsRefusedWithASentence) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const auto& message) { return !from_wire(message) && !from_wire(message).fault().empty(); };
  auto state = to_wire(some_state());
  state.x_m = nan;
  EXPECT_TRUE(refused(state));
  state = to_wire(some_state());
  state.robot = "";
  EXPECT_TRUE(refused(state));
  state = to_wire(some_state());
  state.state = 9;
  EXPECT_TRUE(refused(state));
  state = to_wire(some_state());
  state.path_x_m[1] = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(refused(state));
  TeamTour one;
  one.robot = "R1";
  one.viewpoints = {{{1, 2, 3}, {}, 1}};
  auto tour = to_wire(one);
  tour.viewpoints[0].looks = 0;
  EXPECT_TRUE(refused(tour));
  tour = to_wire(one);
  tour.valid_s = nan;
  EXPECT_TRUE(refused(tour));
  auto report = to_wire(TourReport{Time{}, "R1", {}});
  report.event = 3;
  EXPECT_TRUE(refused(report));
}

}  // namespace
}  // namespace arpent::planning
