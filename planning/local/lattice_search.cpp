// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/lattice_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <unordered_map>

namespace arpent::planning {
namespace {

constexpr double kBinM = 0.1;
constexpr int kHeadingBins = 24;
constexpr double kTurnStepRad = std::numbers::pi / 6;
/// Turns in a row stay below half a circle: the tracker takes the shorter way round.
constexpr double kMaxTurnsRad = 3.0;
/// Shares of the greatest curvature.
constexpr std::array<double, 5> kCurvatures = {0, 0.5, -0.5, 1, -1};
/// Nodes nearer to the goal than this are all tried to be joined to it, of the others one in so many.
constexpr double kAlwaysJoinM = 2.0;
constexpr int kJoinEvery = 4;

struct Node {
  Pose2 pose;
  double cost = 0;
  double driven_m = 0;
  double turned_rad = 0;  ///< by the turns that led here in a row
  int parent = -1;
  Motion motion;  ///< from the parent
};

class Search {
 public:
  Search(const Ground& ground, const Pose2& goal, const Sweep& to_goal, const LatticeParams& params,
         const StartSlack& slack)
      : ground_(ground), goal_(goal), to_goal_(to_goal), params_(params), slack_(slack) {}

  LatticeResult run(const Pose2& start) {
    LatticeResult result;
    add({start, 0, 0, 0, -1, {}});
    int refining = 0;
    while (!open_.empty() && open_.top().first < best_cost_) {
      const int index = open_.top().second;
      open_.pop();
      if (nodes_[static_cast<std::size_t>(index)].cost > costs_.at(bin_of(nodes_[static_cast<std::size_t>(index)])))
        continue;
      if (result.expansions >= params_.max_expansions) {
        result.out_of_budget = true;
        break;
      }
      if (best_node_ >= 0 && refining++ >= params_.max_refining_expansions) break;
      join(index, result.expansions++);
      expand(index);
    }
    if (best_node_ >= 0) result.motions = way();
    return result;
  }

 private:
  using Open = std::pair<double, int>;

  [[nodiscard]] std::optional<double> estimate(const Pose2& pose) const {
    const GridFrame& frame = ground_.frame();
    const Eigen::Vector2i cell = frame.cell_of(pose.position_m());
    if (!frame.has(cell.x(), cell.y())) return std::nullopt;
    const std::uint32_t units = to_goal_.costs()[frame.at(cell.x(), cell.y())];
    if (units != Sweep::kNotReached) return static_cast<double>(units) / Sweep::kUnitsPerCell * frame.cell_m;
    return to_goal_.cost_m(pose.position_m());
  }

  [[nodiscard]] static std::uint64_t bin_of(const Node& node) {
    const auto bin = [](double value) { return static_cast<std::uint64_t>(std::lround(value) + (1 << 20)); };
    const long heading = std::lround(node.pose.yaw_rad / (2 * std::numbers::pi) * kHeadingBins);
    // A standing robot and a driving one are different: only one of them pays for the stop.
    const std::uint64_t turning = node.turned_rad != 0 ? 1 : 0;
    return ((bin(node.pose.x_m / kBinM) << 21 | bin(node.pose.y_m / kBinM)) << 6 |
            static_cast<std::uint64_t>((heading + kHeadingBins) % kHeadingBins))
               << 1 |
           turning;
  }

  void add(const Node& node) {
    const auto estimate_m = estimate(node.pose);
    if (!estimate_m || node.cost + *estimate_m >= best_cost_) return;
    const auto [held, fresh] = costs_.try_emplace(bin_of(node), node.cost);
    if (!fresh) {
      if (held->second <= node.cost) return;
      held->second = node.cost;
    }
    nodes_.push_back(node);
    open_.emplace(node.cost + *estimate_m, static_cast<int>(nodes_.size()) - 1);
  }

  void expand(int index) {
    const Node node = nodes_[static_cast<std::size_t>(index)];
    for (const double share : kCurvatures) {
      try_motion(node, index, drive(node.pose, params_.step_m, share / params_.turn_radius_m));
    }
    for (const double side : {1.0, -1.0}) {
      if (node.turned_rad * side < 0 || std::abs(node.turned_rad) + kTurnStepRad > kMaxTurnsRad) continue;
      try_motion(node, index, {node.pose, 0, 0, side * kTurnStepRad});
    }
  }

  void try_motion(const Node& from, int parent, const Motion& motion) {
    Node node;
    node.pose = end_of(motion);
    node.cost = from.cost + ground_.cost_of(motion);
    if (motion.is_turn() && from.turned_rad != 0) node.cost -= ground_.costs().stop_m;
    node.driven_m = from.driven_m + motion.length_m;
    node.turned_rad = motion.is_turn() ? from.turned_rad + motion.turn_rad : 0;
    node.parent = parent;
    node.motion = motion;
    const auto held = costs_.find(bin_of(node));
    if (held != costs_.end() && held->second <= node.cost) return;
    if (first_contact(ground_, {motion}, {slack_.depth_m, slack_.along_m - from.driven_m})) return;
    add(node);
  }

  /// Tries to reach the goal directly from a node.
  void join(int index, int expansions) {
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    const double away_m = (node.pose.position_m() - goal_.position_m()).norm();
    if (away_m > kAlwaysJoinM && expansions % kJoinEvery != 0) return;
    const StartSlack slack{slack_.depth_m, slack_.along_m - node.driven_m};
    auto tail = connect(ground_, node.pose, goal_, params_.turn_radius_m, best_cost_ - node.cost, slack);
    if (!tail) return;
    best_cost_ = node.cost + ground_.cost_of(*tail);
    best_node_ = index;
    tail_ = std::move(*tail);
  }

  [[nodiscard]] Motions way() const {
    Motions motions;
    for (int i = best_node_; nodes_[static_cast<std::size_t>(i)].parent >= 0;
         i = nodes_[static_cast<std::size_t>(i)].parent) {
      motions.push_back(nodes_[static_cast<std::size_t>(i)].motion);
    }
    std::reverse(motions.begin(), motions.end());
    motions.insert(motions.end(), tail_.begin(), tail_.end());
    return tidy(motions);
  }

  const Ground& ground_;
  const Pose2 goal_;
  const Sweep& to_goal_;
  const LatticeParams& params_;
  const StartSlack slack_;
  std::vector<Node> nodes_;
  std::unordered_map<std::uint64_t, double> costs_;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open_;
  double best_cost_ = std::numeric_limits<double>::infinity();
  int best_node_ = -1;
  Motions tail_;
};

constexpr double kVertexSpacingM = 0.5;
constexpr std::size_t kWindow = 16;
constexpr int kPasses = 2;
constexpr double kLeastGain = 0.01;
/// Gentler turns are tried first.
constexpr std::array<double, 2> kRadii = {2.0, 1.0};

/// Cuts drives into parts no longer than the spacing.
Motions cut(const Motions& motions) {
  Motions parts;
  for (const Motion& motion : motions) {
    const int count = motion.is_turn() ? 1 : static_cast<int>(std::ceil(motion.length_m / kVertexSpacingM));
    for (int i = 0; i < count; ++i) {
      Motion part = motion;
      if (count > 1) {
        part.start = pose_at(motion, static_cast<double>(i) / count);
        part.length_m /= count;
      }
      parts.push_back(part);
    }
  }
  return parts;
}

/// A cheaper way over arcs for the parts first .. last - 1.
std::optional<Motions> find_shortcut(const Ground& ground, const Pose2& from, const Pose2& to, double cost,
                                     double radius_m, const StartSlack& slack) {
  if ((from.position_m() - to.position_m()).norm() > cost - kLeastGain) return std::nullopt;
  for (const double scale : kRadii) {
    for (Motions& way : connect_with_arcs(from, to, scale * radius_m)) {
      if (length_of(way) > cost - kLeastGain) break;
      if (ground.cost_of(way) > cost - kLeastGain || first_contact(ground, way, slack)) continue;
      return std::move(way);
    }
  }
  return std::nullopt;
}

Motions shorten_once(const Ground& ground, const Motions& motions, double radius_m, const StartSlack& slack) {
  const Motions parts = cut(motions);
  std::vector<double> cost(parts.size() + 1, 0.0), driven(parts.size() + 1, 0.0);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    cost[i + 1] = cost[i] + ground.cost_of(parts[i]);
    driven[i + 1] = driven[i] + parts[i].length_m;
  }
  Motions way;
  for (std::size_t i = 0; i < parts.size();) {
    std::size_t next = i + 1;
    Motions taken = {parts[i]};
    for (std::size_t j = std::min(parts.size(), i + kWindow); j > i + 1; --j) {
      auto shortcut = find_shortcut(ground, parts[i].start, end_of(parts[j - 1]), cost[j] - cost[i], radius_m,
                                    {slack.depth_m, slack.along_m - driven[i]});
      if (!shortcut) continue;
      taken = std::move(*shortcut);
      next = j;
      break;
    }
    way.insert(way.end(), taken.begin(), taken.end());
    i = next;
  }
  return tidy(way);
}

}  // namespace

std::optional<Motions> connect(const Ground& ground, const Pose2& start, const Pose2& goal, double radius_m,
                               double bound, const StartSlack& slack) {
  std::vector<Motions> ways = connect_with_arcs(start, goal, radius_m);
  for (Motions& way : connect_then_turn(start, goal, radius_m)) ways.push_back(std::move(way));
  ways.push_back(turn_drive_turn(start, goal));
  std::optional<Motions> best;
  for (Motions& way : ways) {
    if (length_of(way) >= bound) continue;
    const double cost = ground.cost_of(way);
    if (cost >= bound || first_contact(ground, way, slack)) continue;
    bound = cost;
    best = std::move(way);
  }
  return best;
}

LatticeResult search_lattice(const Ground& ground, const Pose2& start, const Pose2& goal, const Sweep& to_goal,
                             const LatticeParams& params, const StartSlack& slack) {
  return Search(ground, goal, to_goal, params, slack).run(start);
}

Motions shorten(const Ground& ground, const Motions& motions, double radius_m, const StartSlack& slack) {
  Motions way = motions;
  for (int pass = 0; pass < kPasses; ++pass) way = shorten_once(ground, way, radius_m, slack);
  return way;
}

}  // namespace arpent::planning
