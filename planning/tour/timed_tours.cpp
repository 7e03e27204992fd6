// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/tour/timed_tours.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>

#include "common/error.h"
#include "planning/tour/held_karp.h"

namespace arpent::tour {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Stands for "no way" inside the search, where sums and differences of infinities would be no numbers.
constexpr double kNoWayS = 1e7;
constexpr int kExactClusters = 12;
/// Ruin: clusters removed at a time; recreate: the share of places not looked at. Both as in the paper's range.
constexpr int kMostRemoved = 10;
constexpr int kLongestString = 6;
constexpr std::uint64_t kBlinkOneIn = 100;
/// Tours worse than the last by this share of the objective are accepted at first; the allowance falls to nothing and
/// starts anew, so that the course does not depend on the budget.
constexpr double kAllowance = 0.03;
constexpr int kCycle = 500;

using Routes = std::vector<std::vector<int>>;

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

class Search {
 public:
  Search(const Arcs& legs_s, const std::vector<double>& gain, const TimedParams& params)
      : legs_s_(legs_s), gain_(gain), params_(params), n_(static_cast<int>(gain.size())) {
    for (double& g : gain_) total_gain_ += g;
    if (total_gain_ > 0) {
      for (double& g : gain_) g /= total_gain_;
    }
    rank_neighbours();
  }

  Routes run(Routes routes, std::vector<int> missing) {
    routes_ = std::move(routes);
    measure();
    recreate(missing, false);
    Routes best = routes_, current = routes_;
    double best_value = value(), current_value = best_value;
    const auto most = static_cast<std::int64_t>(params_.steps);
    for (int turn = 0; steps_ < most && n_ > 1; ++turn) {
      std::vector<int> removed = ruin();
      shuffle(removed);
      recreate(removed, true);
      const double allowance = kAllowance * best_value * (1 - static_cast<double>(turn % kCycle) / kCycle) * uniform();
      if (value() < best_value) {
        best = routes_;
        best_value = value();
      }
      if (value() < current_value + allowance) {
        current = routes_;
        current_value = value();
      } else {
        routes_ = current;
        measure();
      }
    }
    return best;
  }

 private:
  struct Place {
    double cost = kInfinity;
    std::size_t route = 0, position = 0;
  };

  [[nodiscard]] double leg(std::size_t route, int from, int to) const {
    return from < 0 ? legs_s_.from_start(static_cast<Eigen::Index>(route), to) : legs_s_.among(from, to);
  }

  void rank_neighbours() {
    neighbours_.resize(index(n_));
    for (int u = 0; u < n_; ++u) {
      const auto apart = [&](int v) { return v == u ? -1.0 : std::min(legs_s_.among(u, v), legs_s_.among(v, u)); };
      std::vector<int>& ranked = neighbours_[index(u)];
      ranked.resize(index(n_));
      std::iota(ranked.begin(), ranked.end(), 0);
      std::stable_sort(ranked.begin(), ranked.end(), [&](int a, int b) { return apart(a) < apart(b); });
    }
  }

  void measure() {
    arrival_.resize(routes_.size());
    later_gain_.resize(routes_.size());
    end_s_.resize(routes_.size());
    latency_s_.assign(routes_.size(), 0.0);
    for (std::size_t r = 0; r < routes_.size(); ++r) measure_route(r);
  }

  /// Arrival times, the gain from each position on, and what the route adds to the mean arrival.
  void measure_route(std::size_t r) {
    const std::vector<int>& route = routes_[r];
    arrival_[r].resize(route.size());
    later_gain_[r].assign(route.size() + 1, 0.0);
    double t = 0;
    latency_s_[r] = 0;
    for (std::size_t p = 0; p < route.size(); ++p) {
      t += leg(r, p == 0 ? -1 : route[p - 1], route[p]);
      arrival_[r][p] = t;
      latency_s_[r] += gain_[index(route[p])] * t;
    }
    end_s_[r] = t;
    for (std::size_t p = route.size(); p-- > 0;) {
      later_gain_[r][p] = later_gain_[r][p + 1] + gain_[index(route[p])];
    }
  }

  [[nodiscard]] double value() const {
    return std::accumulate(latency_s_.begin(), latency_s_.end(), 0.0) +
           params_.completion_weight * *std::max_element(end_s_.begin(), end_s_.end());
  }

  [[nodiscard]] std::uint64_t draw(std::uint64_t below) { return random_() % below; }
  [[nodiscard]] double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  void shuffle(std::vector<int>& list) {
    for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[draw(i)]);
  }

  /// Removes strings of visits around a random cluster: one string per tour that comes near it.
  std::vector<int> ruin() {
    const auto goal = 1 + draw(static_cast<std::uint64_t>(std::min(kMostRemoved, n_)));
    std::vector<int> removed;
    std::vector<char> ruined(routes_.size(), 0);
    for (const int near : neighbours_[draw(static_cast<std::uint64_t>(n_))]) {
      if (removed.size() >= goal) break;
      for (std::size_t r = 0; r < routes_.size(); ++r) {
        const auto found = std::find(routes_[r].begin(), routes_[r].end(), near);
        if (found == routes_[r].end()) continue;
        // With one robot all strings come from its tour; with several, one from each, so that they exchange.
        if (routes_.size() > 1 && ruined[r] != 0 && draw(2) == 0) break;
        ruined[r] = 1;
        cut_string(r, static_cast<std::size_t>(found - routes_[r].begin()), goal - removed.size(), removed);
        break;
      }
    }
    measure();
    return removed;
  }

  void cut_string(std::size_t r, std::size_t at, std::size_t most, std::vector<int>& removed) {
    std::vector<int>& route = routes_[r];
    const std::size_t length = std::min({1 + draw(kLongestString), most, route.size()});
    const std::size_t first = at + 1 - std::min(at + 1, length), last = std::min(at, route.size() - length);
    const auto begin = route.begin() + static_cast<std::ptrdiff_t>(first + draw(last - first + 1));
    removed.insert(removed.end(), begin, begin + static_cast<std::ptrdiff_t>(length));
    route.erase(begin, begin + static_cast<std::ptrdiff_t>(length));
  }

  /// Puts each cluster where it costs least at the moment.
  void recreate(const std::vector<int>& missing, bool blink) {
    for (const int v : missing) {
      const Place place = cheapest_place(v, blink);
      std::vector<int>& route = routes_[place.route];
      route.insert(route.begin() + static_cast<std::ptrdiff_t>(place.position), v);
      measure_route(place.route);
    }
  }

  Place cheapest_place(int v, bool blink) {
    Place best;
    const double completion_s = *std::max_element(end_s_.begin(), end_s_.end());
    for (std::size_t r = 0; r < routes_.size(); ++r) {
      const std::vector<int>& route = routes_[r];
      for (std::size_t p = 0; p <= route.size(); ++p) {
        ++steps_;
        if (blink && best.cost < kInfinity && draw(kBlinkOneIn) == 0) continue;
        const int before = p == 0 ? -1 : route[p - 1];
        const double arrival_s = (p == 0 ? 0.0 : arrival_[r][p - 1]) + leg(r, before, v);
        double later_s = arrival_s - (p == 0 ? 0.0 : arrival_[r][p - 1]);
        if (p < route.size()) later_s += leg(r, v, route[p]) - leg(r, before, route[p]);
        const double cost = gain_[index(v)] * arrival_s + later_gain_[r][p] * later_s +
                            params_.completion_weight * std::max(0.0, end_s_[r] + later_s - completion_s);
        // A robot with time to spare takes what the last one would be later for; among equals the shorter detour.
        if (cost + kTieShare * later_s < best.cost) best = {cost + kTieShare * later_s, r, p};
      }
    }
    return best;
  }

  static constexpr double kTieShare = 1e-3;

  const Arcs& legs_s_;
  std::vector<double> gain_;
  const TimedParams& params_;
  int n_;
  double total_gain_ = 0;
  std::vector<std::vector<int>> neighbours_;
  Routes routes_;
  std::vector<std::vector<double>> arrival_, later_gain_;
  std::vector<double> end_s_, latency_s_;
  std::mt19937_64 random_{1};
  std::int64_t steps_ = 0;
};

void check(const Arcs& legs_s, const std::vector<double>& gain) {
  const auto n = static_cast<Eigen::Index>(gain.size());
  ARPENT_ASSERT(legs_s.among.rows() == n && legs_s.among.cols() == n && legs_s.from_start.cols() == n &&
                legs_s.from_start.rows() >= 1);
  for (Eigen::Index v = 0; v < n; ++v) {
    if (!(gain[static_cast<std::size_t>(v)] >= 0)) throw InputError("timed tours: a gain is negative or not a number");
    for (Eigen::Index u = 0; u < n; ++u) {
      if (u != v && !(legs_s.among(u, v) >= 0)) throw InputError("timed tours: a time is negative or not a number");
    }
    if (!(legs_s.from_start.col(v).array() >= 0).all()) {
      throw InputError("timed tours: a time is negative or not a number");
    }
  }
}

/// With finite stand-ins for what has no way.
Arcs finite(const Arcs& legs_s) {
  const auto stand_in = [](double t_s) { return std::min(t_s, kNoWayS); };
  return {legs_s.among.unaryExpr(stand_in), legs_s.from_start.unaryExpr(stand_in)};
}

std::vector<int> exact(const Arcs& legs_s, const std::vector<double>& gain, const std::vector<int>& clusters,
                       double completion_weight) {
  const auto n = static_cast<Eigen::Index>(clusters.size());
  Matrix cost = Matrix::Zero(n + 1, n + 1);
  std::vector<double> weight(static_cast<std::size_t>(n) + 1, 0.0);
  const double total = std::accumulate(gain.begin(), gain.end(), 0.0);
  for (Eigen::Index j = 0; j < n; ++j) {
    const int v = clusters[static_cast<std::size_t>(j)];
    cost(0, j + 1) = legs_s.from_start(0, v);
    if (total > 0) weight[static_cast<std::size_t>(j) + 1] = gain[index(v)] / total;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (i != j) cost(i + 1, j + 1) = legs_s.among(clusters[static_cast<std::size_t>(i)], v);
    }
  }
  std::vector<int> order;
  for (const int node : exact_weighted_tour(cost, completion_weight, weight)) {
    if (node > 0) order.push_back(clusters[index(node - 1)]);
  }
  return order;
}

/// Ends each tour before the first leg without a way.
void cut_where_no_way(const Arcs& legs_s, Routes& routes, std::vector<int>& unreachable) {
  for (std::size_t r = 0; r < routes.size(); ++r) {
    std::vector<int>& route = routes[r];
    for (std::size_t p = 0; p < route.size(); ++p) {
      const double leg_s =
          p == 0 ? legs_s.from_start(static_cast<Eigen::Index>(r), route[p]) : legs_s.among(route[p - 1], route[p]);
      if (std::isfinite(leg_s)) continue;
      unreachable.insert(unreachable.end(), route.begin() + static_cast<std::ptrdiff_t>(p), route.end());
      route.resize(p);
    }
  }
  std::sort(unreachable.begin(), unreachable.end());
}

}  // namespace

TimedTours timed_tours(const Arcs& legs_s, const std::vector<double>& gain, const TimedParams& params,
                       const std::vector<std::vector<int>>& warm) {
  check(legs_s, gain);
  const auto robots = static_cast<std::size_t>(legs_s.from_start.rows());
  ARPENT_ASSERT(warm.empty() || warm.size() == robots);
  Routes routes(robots);
  std::vector<char> placed(gain.size(), 0);
  std::vector<int> unreachable, reachable, missing;
  for (int v = 0; v < static_cast<int>(gain.size()); ++v) {
    (legs_s.from_start.col(v).array().isFinite().any() ? reachable : unreachable).push_back(v);
  }
  std::vector<double> reachable_gain = gain;
  for (const int v : unreachable) {
    placed[index(v)] = 1;
    reachable_gain[index(v)] = 0;
  }
  for (std::size_t r = 0; r < warm.size(); ++r) {
    for (const int v : warm[r]) {
      if (placed[index(v)]++ == 0) routes[r].push_back(v);
    }
  }
  for (const int v : reachable) {
    if (placed[index(v)] == 0) missing.push_back(v);
  }
  const Arcs legs = finite(legs_s);
  if (robots == 1 && static_cast<int>(reachable.size()) <= kExactClusters) {
    routes[0] = exact(legs, reachable_gain, reachable, params.completion_weight);
  } else {
    routes = Search(legs, reachable_gain, params).run(std::move(routes), std::move(missing));
  }
  cut_where_no_way(legs_s, routes, unreachable);
  TimedTours tours = evaluate_timed(legs_s, gain, params, std::move(routes));
  tours.unreachable = std::move(unreachable);
  return tours;
}

TimedTours evaluate_timed(const Arcs& legs_s, const std::vector<double>& gain, const TimedParams& params,
                          std::vector<std::vector<int>> order) {
  TimedTours tours;
  double visited_gain = 0, weighted_s = 0;
  for (std::size_t r = 0; r < order.size(); ++r) {
    double t = 0;
    for (std::size_t p = 0; p < order[r].size(); ++p) {
      const int v = order[r][p];
      t += p == 0 ? legs_s.from_start(static_cast<Eigen::Index>(r), v) : legs_s.among(order[r][p - 1], v);
      visited_gain += gain[index(v)];
      weighted_s += gain[index(v)] * t;
    }
    tours.completion_s = std::max(tours.completion_s, t);
  }
  tours.mean_arrival_s = visited_gain > 0 ? weighted_s / visited_gain : 0;
  tours.objective_s = tours.mean_arrival_s + params.completion_weight * tours.completion_s;
  tours.order = std::move(order);
  return tours;
}

}  // namespace arpent::tour
