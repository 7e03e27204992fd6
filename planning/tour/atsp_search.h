// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The closed asymmetric travelling salesman problem (ATSP) by local search: moves of the Lin-Kernighan class that never
// reverse a piece of the tour (an arc's cost differs from its reverse's), restarted from small random kicks. Anytime:
// its budget is a number of steps, so that its result depends on nothing but its arguments.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "planning/tour/lower_bound.h"
#include "planning/tour/matrix.h"

namespace arpent::tour {

/// Sum of the arcs of the closed tour.
[[nodiscard]] double closed_cost(const Matrix& cost, const std::vector<int>& tour);

/// Cheapest-insertion tour: inserts the nodes missing in `partial` (a tour through some, at least one) where they cost
/// least, the cheapest first. O(n^3) at worst.
[[nodiscard]] std::vector<int> insert_missing(const Matrix& cost, std::vector<int> partial);

class AtspSearch {
 public:
  /// `cost` is n x n, n >= 2, finite off the diagonal (which is ignored); copied. `bound` belongs to `cost`: its
  /// multipliers choose the candidate arcs, its value ends the search when a tour attains it. Starts from `tour`, a
  /// permutation of all nodes, made locally optimal by the first `run`.
  AtspSearch(const Matrix& cost, const Bound& bound, std::vector<int> tour, std::uint64_t seed = 1);

  /// Searches on until `steps` in total (one step looks at one candidate arc or moves one node; a kick once
  /// begun is finished). The state
  /// depends on the largest total asked for, not on how it was divided into calls. More steps never make `best` worse.
  void run_until(std::int64_t steps);

  [[nodiscard]] std::int64_t steps() const { return steps_; }
  [[nodiscard]] const std::vector<int>& best() const { return best_; }
  /// Of the best tour, in the units of `cost`.
  [[nodiscard]] double best_cost() const { return closed_cost(cost_, best_); }
  /// Whether the best tour attains the bound.
  [[nodiscard]] bool proven() const { return best_reduced_ <= tight_; }

 private:
  struct Exchange {
    double open = 0;    ///< gain before the arc that closes it
    double closed = 0;  ///< gain of the tour
    int b = 0, c = 0;
  };
  struct Link {
    int a, b, c;
  };

  [[nodiscard]] double arc(int i, int j) const { return reduced_[static_cast<std::size_t>(i * n_ + j)]; }
  [[nodiscard]] int at(int position) const;
  [[nodiscard]] int after(int node) const { return at(place_[static_cast<std::size_t>(node)] + 1); }
  [[nodiscard]] int before(int node) const { return at(place_[static_cast<std::size_t>(node)] - 1); }
  [[nodiscard]] int ahead(int from, int to) const;
  void list_candidates();
  void set_tour(const std::vector<int>& tour);
  void touch(int node);
  void touch_both_ends(int node);
  void improve();
  bool improve_at(int node);
  [[nodiscard]] Exchange find_exchange(int a, double gain);
  [[nodiscard]] bool added(int node) const;
  void find_third(int a, int b_next, double gain, Exchange& best);
  void exchange(int a, int b, int c);
  void swap_pieces(int position, int first, int second);
  void write(int position);
  void kick();
  void keep_or_undo();

  int n_;
  Matrix cost_;
  std::vector<double> reduced_;  ///< n x n reduced costs: they rank arcs better, and differ by a constant per tour
  std::vector<int> candidates_;  ///< n x width_: each node's cheapest ways on
  int width_ = 0;
  double tight_ = 0;  ///< a tour of this reduced cost attains the bound
  double epsilon_ = 0;
  double temperature_ = 0;
  std::vector<int> order_, place_;  ///< the tour, and where in it each node is
  std::vector<int> queue_;          ///< nodes whose arcs changed ("don't look" at the others)
  std::vector<char> queued_;
  std::vector<Link> chain_;
  std::vector<int> scratch_, kept_, best_;
  double tour_reduced_ = 0, kept_reduced_ = 0, best_reduced_ = 0;
  std::mt19937_64 random_;
  std::int64_t steps_ = 0, kicks_ = 0;
  bool started_ = false;
};

}  // namespace arpent::tour
