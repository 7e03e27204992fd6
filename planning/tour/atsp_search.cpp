// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/tour/atsp_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "common/error.h"

namespace arpent::tour {
namespace {

/// Candidate arcs that leave a node.
constexpr int kCandidates = 10;
/// Exchanges in a chain.
constexpr std::size_t kDepth = 10;
/// Longest of the three pieces that a kick reorders.
constexpr int kKickLength = 30;
/// Allowance for worse tours after a kick, as a share of the spread of the candidate arcs.
constexpr double kTemperature = 3.0;
/// Kicks per node in which the allowance falls from that to nothing, before it starts anew: it frees the search from
/// deep local optima, and its course does not depend on the budget.
constexpr std::int64_t kCyclePerNode = 50;
/// Gains below this share of the cost's scale are rounding.
constexpr double kRelativeEpsilon = 1e-12;

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

double closed_cost(const Matrix& cost, const std::vector<int>& tour) {
  double sum = 0;
  for (std::size_t i = 0; i < tour.size(); ++i) sum += cost(tour[i], tour[(i + 1) % tour.size()]);
  return sum;
}

std::vector<int> insert_missing(const Matrix& cost, std::vector<int> partial) {
  const int n = static_cast<int>(cost.rows());
  ARPENT_ASSERT(!partial.empty());
  std::vector<int> missing;
  for (int i = 0; i < n; ++i) {
    if (std::find(partial.begin(), partial.end(), i) == partial.end()) missing.push_back(i);
  }
  while (!missing.empty()) {
    double least = std::numeric_limits<double>::infinity();
    std::size_t which = 0, where = 0;
    for (std::size_t m = 0; m < missing.size(); ++m) {
      for (std::size_t p = 0; p < partial.size(); ++p) {
        const int from = partial[p], to = partial[(p + 1) % partial.size()];
        const double replaced = from == to ? 0 : cost(from, to);
        const double added = cost(from, missing[m]) + cost(missing[m], to) - replaced;
        if (added < least) {
          least = added;
          which = m;
          where = p;
        }
      }
    }
    partial.insert(partial.begin() + static_cast<std::ptrdiff_t>(where) + 1, missing[which]);
    missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(which));
  }
  return partial;
}

AtspSearch::AtspSearch(const Matrix& cost, const Bound& bound, std::vector<int> tour, std::uint64_t seed)
    : n_(static_cast<int>(cost.rows())),
      cost_(cost),
      reduced_(index(n_ * n_)),
      place_(index(n_)),
      queued_(index(n_), 0),
      random_(seed) {
  ARPENT_ASSERT(n_ >= 2 && cost.cols() == n_ && tour.size() == index(n_));
  double scale = 0;
  for (int i = 0; i < n_; ++i) {
    for (int j = 0; j < n_; ++j) {
      reduced_[index(i * n_ + j)] = i == j ? 0.0 : cost(i, j) - bound.out[index(i)] - bound.in[index(j)];
      if (i != j) scale = std::max(scale, std::abs(cost(i, j)));
    }
  }
  const double multipliers =
      std::accumulate(bound.out.begin(), bound.out.end(), 0.0) + std::accumulate(bound.in.begin(), bound.in.end(), 0.0);
  epsilon_ = kRelativeEpsilon * scale;
  tight_ = bound.value - multipliers + epsilon_ * n_;
  list_candidates();
  set_tour(tour);
  best_ = kept_ = order_;
  best_reduced_ = kept_reduced_ = tour_reduced_;
}

int AtspSearch::at(int position) const {
  const int p = position >= n_ ? position - n_ : position < 0 ? position + n_ : position;
  return order_[index(p)];
}

/// Arcs from `from` on to `to`.
int AtspSearch::ahead(int from, int to) const {
  const int d = place_[index(to)] - place_[index(from)];
  return d < 0 ? d + n_ : d;
}

void AtspSearch::list_candidates() {
  width_ = std::min(kCandidates, n_ - 1);
  candidates_.reserve(index(n_ * width_));
  std::vector<int> others;
  double spread = 0;
  for (int i = 0; i < n_; ++i) {
    others.clear();
    for (int j = 0; j < n_; ++j) {
      if (j != i) others.push_back(j);
    }
    const auto cheaper = [&](int a, int b) { return std::pair(arc(i, a), a) < std::pair(arc(i, b), b); };
    std::partial_sort(others.begin(), others.begin() + width_, others.end(), cheaper);
    candidates_.insert(candidates_.end(), others.begin(), others.begin() + width_);
    spread += arc(i, others[index(std::min(2, width_ - 1))]) - arc(i, others[0]);
  }
  temperature_ = kTemperature * spread / n_;
}

void AtspSearch::set_tour(const std::vector<int>& tour) {
  order_ = tour;
  tour_reduced_ = 0;
  for (int p = 0; p < n_; ++p) {
    place_[index(order_[index(p)])] = p;
    tour_reduced_ += arc(at(p), at(p + 1));
  }
}

void AtspSearch::touch(int node) {
  if (queued_[index(node)] != 0) return;
  queued_[index(node)] = 1;
  queue_.push_back(node);
}

/// The ends of the arc that leaves `node`.
void AtspSearch::touch_both_ends(int node) {
  touch(node);
  touch(after(node));
}

void AtspSearch::run_until(std::int64_t steps) {
  if (!started_) {
    started_ = true;
    for (const int node : order_) touch(node);
    improve();
    keep_or_undo();
  }
  while (steps_ < steps && n_ > 3 && !proven()) {
    kick();
    improve();
    keep_or_undo();
  }
}

void AtspSearch::improve() {
  for (std::size_t next = 0; next < queue_.size(); ++next) {
    const int node = queue_[next];
    queued_[index(node)] = 0;
    while (improve_at(node)) {
    }
  }
  queue_.clear();
}

/// A chain of exchanges from the arc (a, a'), in which each begins with the arc that closed the last one (Lin and
/// Kernighan 1973; without reversal: Kanellakis and Papadimitriou 1980). Stops at the first that gains; if none does,
/// the tour is as before.
bool AtspSearch::improve_at(int a) {
  chain_.clear();
  double gain = arc(a, after(a));
  while (chain_.size() < kDepth) {
    const Exchange step = find_exchange(a, gain);
    if (step.closed > epsilon_) {
      chain_.push_back({a, step.b, step.c});
      for (const Link& link : chain_) {
        for (const int node : {link.a, link.b, link.c}) touch_both_ends(node);
      }
      exchange(a, step.b, step.c);
      for (const Link& link : chain_) {
        for (const int node : {link.a, link.b, link.c}) touch_both_ends(node);
      }
      tour_reduced_ -= step.closed;
      return true;
    }
    if (step.open <= epsilon_) break;
    exchange(a, step.b, step.c);
    chain_.push_back({a, step.b, step.c});
    a = step.c;
    gain = step.open;
  }
  for (; !chain_.empty(); chain_.pop_back()) exchange(chain_.back().a, chain_.back().c, chain_.back().b);
  return false;
}

/// Three arcs (a, a'), (b, b'), (c, c') in the tour's order become (a, b'), (b, c'), (c, a'): the two pieces between
/// them change places. `gain` is what the removed arcs save over the added ones so far, (a, a') included. Any exchange
/// that gains has a rotation whose partial sums all gain, so that cutting the search at the first loss misses none
/// among the candidate arcs. Returns the one that gains most when closed, or else the one that leaves most for the next
/// link.
AtspSearch::Exchange AtspSearch::find_exchange(int a, double gain) {
  Exchange best;
  const int a_next = after(a);
  for (int k = 0; k < width_; ++k) {
    const int b_next = candidates_[index(a * width_ + k)];
    ++steps_;
    const double left = gain - arc(a, b_next);
    if (left <= epsilon_) break;
    if (b_next == a_next || added(before(b_next))) continue;
    find_third(a, b_next, left, best);
  }
  return best;
}

/// The best (c, c') behind b'.
void AtspSearch::find_third(int a, int b_next, double gain, Exchange& best) {
  const int a_next = after(a), b = before(b_next);
  const double open_gain = gain + arc(b, b_next);
  const int most = ahead(b_next, a);
  for (int k = 0; k < width_; ++k) {
    const int c_next = candidates_[index(b * width_ + k)];
    ++steps_;
    const double left = open_gain - arc(b, c_next);
    if (left <= epsilon_) break;
    const int distance = ahead(b_next, c_next);
    if (distance == 0 || distance > most) continue;
    const int c = before(c_next);
    if (added(c)) continue;
    const double open = left + arc(c, c_next), closed = open - arc(c, a_next);
    const bool better = best.closed > epsilon_ || closed > epsilon_ ? closed > best.closed : open > best.open;
    if (better) best = {open, closed, b, c};
  }
}

/// Whether the arc that leaves `node` was put in by the present chain, which must not take it out again.
bool AtspSearch::added(int node) const {
  return std::any_of(chain_.begin(), chain_.end(), [&](const Link& link) { return link.a == node || link.b == node; });
}

void AtspSearch::exchange(int a, int b, int c) {
  const int a_next = after(a), b_next = after(b), c_next = after(c);
  const int first = ahead(a_next, b) + 1, second = ahead(b_next, c) + 1, third = n_ - first - second;
  // In a cycle, swapping any two of the three pieces is the same move: leave the longest where it is.
  if (third >= first && third >= second) {
    swap_pieces(place_[index(a_next)], first, second);
  } else if (first >= second) {
    swap_pieces(place_[index(b_next)], second, third);
  } else {
    swap_pieces(place_[index(c_next)], third, first);
  }
}

void AtspSearch::swap_pieces(int position, int first, int second) {
  steps_ += first + second;
  scratch_.clear();
  for (int i = 0; i < second; ++i) scratch_.push_back(order_[index((position + first + i) % n_)]);
  for (int i = 0; i < first; ++i) scratch_.push_back(order_[index((position + i) % n_)]);
  write(position);
}

void AtspSearch::write(int position) {
  for (const int node : scratch_) {
    order_[index(position)] = node;
    place_[index(node)] = position;
    position = position + 1 == n_ ? 0 : position + 1;
  }
}

/// A double bridge near a random place: three neighbouring pieces come in the opposite order. It changes four arcs and
/// no exchange of three undoes it (Martin, Otto and Felten 1991).
void AtspSearch::kick() {
  const int longest = std::min(kKickLength, (n_ - 1) / 3);
  const auto draw = [&](int below) { return static_cast<int>(random_() % static_cast<std::uint64_t>(below)); };
  const int begin = draw(n_);
  const int length[3] = {1 + draw(longest), 1 + draw(longest), 1 + draw(longest)};
  const int cut[4] = {begin, begin + length[0], begin + length[0] + length[1],
                      begin + length[0] + length[1] + length[2]};
  const auto node = [&](int position) { return order_[index(position % n_)]; };
  for (const int c : cut) {
    touch(node(c + n_ - 1));
    touch(node(c));
    tour_reduced_ -= arc(node(c + n_ - 1), node(c));
  }
  scratch_.clear();
  for (int piece = 2; piece >= 0; --piece) {
    for (int i = 0; i < length[piece]; ++i) scratch_.push_back(node(cut[piece] + i));
  }
  write(begin);
  const int joint[4] = {begin, begin + length[2], begin + length[2] + length[1], cut[3]};
  for (const int j : joint) tour_reduced_ += arc(node(j + n_ - 1), node(j));
}

/// Goes on from the new tour if it is not worse than the last one by more than a random allowance.
void AtspSearch::keep_or_undo() {
  if (tour_reduced_ < best_reduced_ - epsilon_) {
    best_ = order_;
    best_reduced_ = tour_reduced_;
  }
  const double uniform = static_cast<double>(random_() >> 11) * 0x1p-53;
  const std::int64_t cycle = kCyclePerNode * n_;
  const double cooled = 1 - static_cast<double>(kicks_++ % cycle) / static_cast<double>(cycle);
  if (tour_reduced_ <= kept_reduced_ - cooled * temperature_ * std::log(1 - uniform)) {
    kept_ = order_;
    kept_reduced_ = tour_reduced_;
  } else {
    order_ = kept_;
    for (int p = 0; p < n_; ++p) place_[index(order_[index(p)])] = p;
    tour_reduced_ = kept_reduced_;
  }
}

}  // namespace arpent::tour
