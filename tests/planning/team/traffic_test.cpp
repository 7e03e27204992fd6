// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Robots that obey the rules drive along given ways, with delay and a brake that takes its time: nobody ever touches.
#include "planning/team/traffic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "common/ellipse.h"

namespace arpent::planning {
namespace {

constexpr double kDt = 0.1;
constexpr double kSpeed = 0.5, kAcceleration = 0.5;

std::vector<Eigen::Vector2d> straight(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  std::vector<Eigen::Vector2d> way;
  const int n = std::max(2, static_cast<int>((b - a).norm() / 0.05));
  for (int i = 0; i <= n; ++i) way.push_back(a + (b - a) * i / n);
  return way;
}

/// A robot on a straight way; it knows what the others said a step ago.
struct Driver {
  std::string name;
  std::vector<Eigen::Vector2d> way;
  Traffic traffic{{}, Footprint(FootprintParams{})};
  double driven_m = 0, speed_mps = 0;
  bool yields = false, lost = false;

  [[nodiscard]] double length_m() const { return (way.back() - way.front()).norm(); }
  [[nodiscard]] Pose2 pose() const {
    const Eigen::Vector2d d = (way.back() - way.front()).normalized();
    const Eigen::Vector2d p = way.front() + driven_m * d;
    return {p.x(), p.y(), std::atan2(d.y(), d.x())};
  }
  [[nodiscard]] Vehicle vehicle(bool as_sent) const {
    Vehicle v{name, pose(), {speed_mps, 0}, {}};
    v.lost = lost;
    const auto passed = static_cast<std::size_t>(driven_m / 0.05);
    if (!lost && !(as_sent && yields) && passed < way.size()) v.path_m = {way.begin() + passed, way.end()};
    return v;
  }
  /// As mission_process does: who was stopped asks before it begins again.
  void obey(Time now, const std::vector<Vehicle>& others) {
    const bool stopped = yields;
    yields = traffic.step(now, vehicle(false), others).advice == TrafficAdvice::kYield;
    if (stopped && !yields) yields = !traffic.may_start(now, vehicle(false), others);
  }
  void move() {
    const bool go = !yields && !lost && driven_m < length_m();
    speed_mps = std::clamp(speed_mps + (go ? kAcceleration : -kAcceleration) * kDt, 0.0, kSpeed);
    if (driven_m >= length_m()) speed_mps = 0;
    driven_m += speed_mps * kDt;
  }
};

struct Outcome {
  bool touched = false, all_there = false;
  double time_s = 0;
};

Outcome drive(std::vector<Driver> drivers, double most_s = 60) {
  Outcome outcome;
  std::vector<Vehicle> said;
  for (const Driver& d : drivers) said.push_back(d.vehicle(true));
  for (double t = 0; t < most_s; t += kDt) {
    const Time now{from_seconds(100 + t)};
    std::vector<Vehicle> next;
    for (Driver& d : drivers) {
      std::vector<Vehicle> others;
      for (const Vehicle& v : said) {
        if (v.name != d.name) others.push_back(v);
      }
      if (!d.lost) d.obey(now, others);
      next.push_back(d.vehicle(true));
    }
    said = next;
    for (Driver& d : drivers) d.move();
    for (std::size_t i = 0; i < drivers.size(); ++i) {
      for (std::size_t j = i + 1; j < drivers.size(); ++j) {
        outcome.touched |= ellipses_overlap(0.55, 0.25, drivers[i].pose(), drivers[j].pose());
      }
    }
    outcome.time_s = t;
    outcome.all_there = std::all_of(drivers.begin(), drivers.end(),
                                    [](const Driver& d) { return d.lost || d.driven_m >= d.length_m(); });
    if (outcome.all_there) break;
  }
  return outcome;
}

TEST(Traffic, OnCrossingWaysTheLaterNameWaitsAndBothArrive) {
  const Outcome outcome = drive({{"R1", straight({-3, 0}, {3, 0})}, {"R2", straight({0, -3}, {0, 3})}});
  EXPECT_FALSE(outcome.touched);
  EXPECT_TRUE(outcome.all_there);
  EXPECT_LT(outcome.time_s, 22) << "6 m take 13 s";
}

TEST(Traffic, WaysThatStayApartCostNothing) {
  const Outcome outcome = drive({{"R1", straight({-3, 0}, {3, 0})}, {"R2", straight({-3, 1.5}, {3, 1.5})}});
  EXPECT_TRUE(outcome.all_there);
  EXPECT_LT(outcome.time_s, 14);
}

TEST(Traffic, HeadOnBothStopApart) {
  const Outcome outcome = drive({{"R1", straight({-3, 0}, {3, 0})}, {"R2", straight({3, 0.1}, {-3, 0.1})}}, 30);
  EXPECT_FALSE(outcome.touched);
  EXPECT_FALSE(outcome.all_there) << "on these ways there is no passing: other ways are the planner's to find";
}

TEST(Traffic, AStandingOrLostRobotIsNotRunInto) {
  for (const bool lost : {true, false}) {
    Driver still{"R2", straight({0, 0}, {0, 0.3})};
    still.lost = lost;
    still.driven_m = lost ? 0 : 1;  // there
    const Outcome outcome = drive({{"R1", straight({-4, 0.1}, {4, 0.1})}, std::move(still)}, 30);
    EXPECT_FALSE(outcome.touched);
  }
}

TEST(Traffic, ARobotThatFellSilentMayStandAnywhereOnTheArcOfItsBraking) {
  const Pose2 last{1, 2, 0.3};
  EXPECT_EQ(resting_places(last, {}).size(), 1U);
  EXPECT_EQ(resting_places(last, {}).front(), last);
  for (const double speed : {0.5, -0.5}) {
    const Twist2 twist{speed, 0.7};
    const std::vector<Pose2> places = resting_places(last, twist);
    EXPECT_EQ(places.front(), last);
    double way_m = 0;
    for (std::size_t i = 1; i < places.size(); ++i) {
      const Eigen::Vector2d step = places[i].position_m() - places[i - 1].position_m();
      way_m += step.norm();
      EXPECT_LE(step.norm(), 0.1 + 1e-9);
      const double middle = 0.5 * (places[i].yaw_rad + places[i - 1].yaw_rad);
      EXPECT_NEAR(step.dot(Eigen::Vector2d(std::cos(middle), std::sin(middle))), std::copysign(step.norm(), speed),
                  1e-9);
    }
    EXPECT_NEAR(way_m, 0.5 * 0.5 + 0.5 * 0.5 / (2 * 0.5), 1e-3) << "half a second, then 0.5 m/s^2";
    EXPECT_NEAR((places.back().yaw_rad - last.yaw_rad) / way_m, 0.7 / 0.5, 1e-3) << "the same arc";
  }
  EXPECT_GT(resting_places(last, {0, 1}).size(), 2U) << "one that turned";
}

TEST(Traffic, AWayPastASilentRobotKeepsOffWhereItMayHaveStopped) {
  Traffic traffic({}, Footprint({}));
  Vehicle mate{"R1", {2, -1.2, 1.57}, {0.5, 0}, {}};
  mate.lost = true;
  const Vehicle own{"R2", {1.1, 0, 0}, {0.4, 0}, straight({1.1, 0}, {4, 0})};
  EXPECT_EQ(traffic.step(Time(), own, {mate}).advice, TrafficAdvice::kYield);
  mate.twist = {};
  Traffic other({}, Footprint({}));
  EXPECT_EQ(other.step(Time(), own, {mate}).advice, TrafficAdvice::kGo);
}

TEST(Traffic, NobodyTouchesOnRandomWays) {
  std::mt19937 random(11);
  const auto draw = [&] { return 4 * (2 * static_cast<double>(random()) * 0x1p-32 - 1); };
  int arrived = 0;
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<Driver> drivers;
    while (drivers.size() < 4) {
      Driver d{"R" + std::to_string(drivers.size() + 1), straight({draw(), draw()}, {draw(), draw()})};
      const bool apart = std::none_of(drivers.begin(), drivers.end(), [&](const Driver& o) {
        return (o.pose().position_m() - d.pose().position_m()).norm() < 1.6;
      });
      if (apart && d.length_m() > 2) drivers.push_back(std::move(d));
    }
    const Outcome outcome = drive(drivers, 60);
    EXPECT_FALSE(outcome.touched) << "trial " << trial;
    arrived += outcome.all_there ? 1 : 0;
  }
  EXPECT_GT(arrived, 20) << "others stand face to face, which the planner has to settle";
}

TEST(Traffic, ANewWayIntoATeammateIsNotBegunAndOneAwayFromItIs) {
  Traffic traffic({}, Footprint(FootprintParams{}));
  const Vehicle mate{"R1", {1.25, 0, 0}, {}, {}};
  Vehicle own{"R2", {}, {}, straight({0, 0}, {3, 0})};
  EXPECT_FALSE(traffic.may_start(Time{from_seconds(1)}, own, {mate}));
  EXPECT_EQ(traffic.step(Time{from_seconds(1.1)}, own, {mate}).because_of, "R1");
  own.backwards = true;
  own.path_m = straight({0, 0}, {-1, 0});
  Traffic fresh({}, Footprint(FootprintParams{}));
  EXPECT_TRUE(fresh.may_start(Time{from_seconds(1)}, own, {mate}));
}

TEST(Traffic, ATurnAtTheEndOfAWayCountsAsWell) {
  Traffic traffic({}, Footprint(FootprintParams{}));
  const Vehicle mate{"R1", {0, 0.7, 0}, {}, {}};  // beside it, 0.2 m apart
  Vehicle own{"R2", {}, {}, {{0, 0}, {0.03, 0}}};
  EXPECT_TRUE(traffic.may_start(Time{from_seconds(1)}, own, {mate}));
  own.end_heading_rad = std::numbers::pi / 2;
  EXPECT_FALSE(traffic.may_start(Time{from_seconds(1)}, own, {mate})) << "its nose would swing into the other";
}

}  // namespace
}  // namespace arpent::planning
