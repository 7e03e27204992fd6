// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/lazy_prm.h"

#include <ompl/base/MotionValidator.h>
#include <ompl/base/StateSampler.h>
#include <ompl/base/spaces/SE2StateSpace.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/prm/LazyPRMstar.h>
#include <ompl/util/Console.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <unordered_set>

namespace arpent::planning {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

using State = ob::SE2StateSpace::StateType;

Pose2 to_pose(const ob::State* state) {
  const auto* s = state->as<State>();
  return {s->getX(), s->getY(), s->getYaw()};
}

/// What the roadmap asks about the ground. Beyond its budget nothing is valid any more: OMPL looks at the termination
/// condition only between solutions.
class Checks {
 public:
  Checks(const Ground& ground, const Pose2& start, const StartSlack& slack, int budget)
      : ground_(ground), start_(start), slack_(slack), left_(budget) {}

  bool pose_is_free(const Pose2& pose) { return --left_ >= 0 && ground_.margin_m(pose) >= -depth_at(pose); }

  /// Turn to the line between two poses, drive along it, turn to the second heading: for the ellipse it does not matter
  /// which end comes first.
  bool way_is_free(const Pose2& from, const Pose2& to) {
    if (--left_ < 0) return false;
    const Eigen::Vector2d d = to.position_m() - from.position_m();
    if (d.norm() < 1e-9) return !ground_.first_contact(turn_to(from, to.yaw_rad), depth_at(from));
    double line = std::atan2(d.y(), d.x());
    const Pose2 along{from.x_m, from.y_m, line};
    const Motion straight = drive(along, d.norm(), 0);
    return !ground_.first_contact(half_turn_to(from, line), depth_at(from)) &&
           !first_contact(ground_, {straight}, {depth_at(from), slack_.along_m}) &&
           !ground_.first_contact(half_turn_to(to, line), depth_at(to));
  }

 private:
  [[nodiscard]] double depth_at(const Pose2& pose) const {
    return (pose.position_m() - start_.position_m()).norm() < 1e-9 ? slack_.depth_m : 0;
  }
  /// To the heading or its opposite, whichever is nearer: the ellipse is the same.
  static Motion half_turn_to(const Pose2& pose, double heading_rad) {
    Motion turn = turn_to(pose, heading_rad);
    turn.turn_rad = std::remainder(turn.turn_rad, std::numbers::pi);
    return turn;
  }

  const Ground& ground_;
  const Pose2 start_;
  const StartSlack slack_;
  int left_;
};

class WayValidator : public ob::MotionValidator {
 public:
  WayValidator(const ob::SpaceInformationPtr& space, Checks& checks) : ob::MotionValidator(space), checks_(checks) {}
  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    return checks_.way_is_free(to_pose(from), to_pose(to));
  }
  bool checkMotion(const ob::State* from, const ob::State* to, std::pair<ob::State*, double>& last) const override {
    last.second = 0;
    return checkMotion(from, to);
  }

 private:
  Checks& checks_;
};

/// Uniform, from a generator of its own: OMPL's are seeded once per program, in the order in which they are made.
class Sampler : public ob::StateSampler {
 public:
  Sampler(const ob::StateSpace* space, const ob::RealVectorBounds& bounds, std::uint32_t seed)
      : ob::StateSampler(space), bounds_(bounds), random_(seed) {}
  void sampleUniform(ob::State* state) override {
    auto* s = state->as<State>();
    s->setXY(uniform(bounds_.low[0], bounds_.high[0]), uniform(bounds_.low[1], bounds_.high[1]));
    s->setYaw(uniform(-std::numbers::pi, std::numbers::pi));
  }
  void sampleUniformNear(ob::State* state, const ob::State* /*near*/, double /*distance*/) override {
    sampleUniform(state);
  }
  void sampleGaussian(ob::State* state, const ob::State* /*mean*/, double /*deviation*/) override {
    sampleUniform(state);
  }

 private:
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(random_()) * 0x1p-32; }

  ob::RealVectorBounds bounds_;
  std::mt19937 random_;
};

/// Frees with itself what was not given back: LazyPRM of OMPL 1.5 leaks the states of vertices that it removes (fixed
/// in 1.6, pull request 909).
class OwningSpace : public ob::SE2StateSpace {
 public:
  ~OwningSpace() override {
    for (ob::State* state : live_) ob::SE2StateSpace::freeState(state);
  }
  ob::State* allocState() const override {
    ob::State* state = ob::SE2StateSpace::allocState();
    live_.insert(state);
    return state;
  }
  void freeState(ob::State* state) const override {
    live_.erase(state);
    ob::SE2StateSpace::freeState(state);
  }

 private:
  mutable std::unordered_set<ob::State*> live_;
};

/// LazyPRM* whose nearest neighbours do not depend on OMPL's random numbers either.
class Roadmap : public og::LazyPRMstar {
 public:
  explicit Roadmap(const ob::SpaceInformationPtr& space) : og::LazyPRMstar(space) {
    nn_ = std::make_shared<ompl::NearestNeighborsLinear<Vertex>>();
    nn_->setDistanceFunction([this](const Vertex a, const Vertex b) { return distanceFunction(a, b); });
  }
};

/// The rectangle around all cells where the robot's centre may be, and both ends.
ob::RealVectorBounds bounds_of(const Ground& ground, const Pose2& start, const Pose2& goal) {
  Eigen::Vector2d least = start.position_m().cwiseMin(goal.position_m());
  Eigen::Vector2d most = start.position_m().cwiseMax(goal.position_m());
  for (std::size_t at = 0; at < ground.weights().size(); ++at) {
    if (ground.weights()[at] == 0) continue;
    least = least.cwiseMin(ground.frame().centre_m(at));
    most = most.cwiseMax(ground.frame().centre_m(at));
  }
  ob::RealVectorBounds bounds(2);
  for (unsigned k = 0; k < 2; ++k) {
    bounds.setLow(k, least[k] - 1e-3);
    bounds.setHigh(k, most[k] + 1e-3);
  }
  return bounds;
}

std::vector<Pose2> solve(const Ground& ground, const Pose2& start, const Pose2& goal, const LazyPrmParams& params,
                         Checks& checks) {
  const auto space = std::make_shared<OwningSpace>();
  const ob::RealVectorBounds bounds = bounds_of(ground, start, goal);
  space->setBounds(bounds);
  space->setStateSamplerAllocator([&](const ob::StateSpace* s) {
    return std::make_shared<Sampler>(s, bounds, static_cast<std::uint32_t>(params.seed));
  });
  const auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker([&](const ob::State* s) { return checks.pose_is_free(to_pose(s)); });
  information->setMotionValidator(std::make_shared<WayValidator>(information, checks));
  information->setup();
  const auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<ob::SE2StateSpace> from(space), to(space);
  from->setXY(start.x_m, start.y_m);
  from->setYaw(wrap_angle(start.yaw_rad));
  to->setXY(goal.x_m, goal.y_m);
  to->setYaw(wrap_angle(goal.yaw_rad));
  problem->setStartAndGoalStates(from, to);
  Roadmap roadmap(information);
  roadmap.setProblemDefinition(problem);
  roadmap.setup();
  int samples_left = params.max_samples;
  (void)roadmap.solve(ob::PlannerTerminationCondition([&] { return --samples_left < 0; }));
  const auto path = std::dynamic_pointer_cast<og::PathGeometric>(problem->getSolutionPath());
  std::vector<Pose2> poses;
  if (path && problem->hasExactSolution()) {
    for (const ob::State* state : path->getStates()) poses.push_back(to_pose(state));
  }
  return poses;
}

/// Two straight lines that meet, joined by an arc: how much of both it takes.
double cut_of_corner(double turn_rad, double radius_m) {
  return radius_m * std::tan(0.5 * std::abs(turn_rad));
}

/// Drives along the polyline; corners are arcs where half of both lines is long enough and nothing is in the way, else
/// turns on the spot.
Motions follow(const Ground& ground, const std::vector<Pose2>& poses, const Pose2& goal, double radius_m,
               const StartSlack& slack) {
  constexpr double kSharpestArcRad = 2.5;
  Motions motions;
  Pose2 at = poses.front();
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Vector2d corner = poses[i].position_m();
    const Eigen::Vector2d line = corner - at.position_m();
    if (line.norm() < 1e-6) continue;
    const Motion turn = turn_to(at, std::atan2(line.y(), line.x()));
    motions.push_back(turn);
    at = end_of(turn);
    double length = line.norm();
    if (i + 1 < poses.size()) {
      const Eigen::Vector2d next = poses[i + 1].position_m() - corner;
      const double angle = wrap_angle(std::atan2(next.y(), next.x()) - at.yaw_rad);
      const double cut = cut_of_corner(angle, radius_m);
      if (std::abs(angle) > 1e-3 && std::abs(angle) < kSharpestArcRad && cut < std::min(length, 0.5 * next.norm())) {
        const Motion before = drive(at, length - cut, 0);
        const Motion arc = drive(end_of(before), radius_m * std::abs(angle), std::copysign(1 / radius_m, angle));
        if (!first_contact(ground, {before, arc}, slack)) {
          motions.push_back(before);
          motions.push_back(arc);
          at = end_of(arc);
          continue;
        }
      }
    }
    motions.push_back(drive(at, length, 0));
    at = end_of(motions.back());
  }
  motions.push_back(turn_to(at, goal.yaw_rad));
  return tidy(motions);
}

}  // namespace

LazyPrmResult plan_lazy_prm(const Ground& ground, const Pose2& start, const Pose2& goal, const LazyPrmParams& params,
                            const StartSlack& slack) {
  // OMPL writes to the console of the whole program otherwise; all that it has to say is in the result.
  ompl::msg::noOutputHandler();
  Checks checks(ground, start, slack, params.max_checks);
  const std::vector<Pose2> poses = solve(ground, start, goal, params, checks);
  LazyPrmResult result;
  result.samples = params.max_samples;
  if (poses.size() >= 2) result.motions = follow(ground, poses, goal, params.turn_radius_m, slack);
  return result;
}

}  // namespace arpent::planning
