// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/tour/three_opt.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "common/error.h"

namespace arpent::tour {
namespace {

/// Less than this share of the path is rounding.
constexpr double kRelativeEpsilon = 1e-12;

/// A path with the lengths of its pieces in both directions, O(1) each.
class MeasuredPath {
 public:
  MeasuredPath(const Matrix& length, std::vector<int> path) : length_(length), path_(std::move(path)) { measure(); }

  [[nodiscard]] const std::vector<int>& path() const { return path_; }

  /// Tries all exchanges once and applies each that shortens the path; false if there was none.
  bool improve() {
    const std::size_t n = path_.size();
    bool improved = false;
    for (std::size_t i = 0; i + 2 < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        for (std::size_t k = j; k < n; ++k) improved = improve_at(i, j, k) || improved;
      }
    }
    return improved;
  }

 private:
  struct Piece {
    std::size_t begin, end;  ///< [begin, end)
    bool reversed;
  };

  /// The pieces (i, j] and (j, k] in either order and direction.
  bool improve_at(std::size_t i, std::size_t j, std::size_t k) {
    const double now = joined(i, {Piece{i + 1, j + 1, false}, Piece{j + 1, k + 1, false}}, k + 1);
    for (int option = 1; option < 8; ++option) {
      std::array<Piece, 2> pieces = {Piece{i + 1, j + 1, (option & 1) != 0}, Piece{j + 1, k + 1, (option & 2) != 0}};
      if ((option & 4) != 0) std::swap(pieces[0], pieces[1]);
      if (joined(i, pieces, k + 1) < now - kRelativeEpsilon * forth_.back()) {
        apply(i + 1, pieces);
        return true;
      }
    }
    return false;
  }

  [[nodiscard]] double joined(std::size_t before, const std::array<Piece, 2>& pieces, std::size_t behind) const {
    double sum = 0;
    int last = path_[before];
    for (const Piece& piece : pieces) {
      if (piece.begin == piece.end) continue;
      const int head = path_[piece.reversed ? piece.end - 1 : piece.begin];
      const std::vector<double>& sums = piece.reversed ? back_ : forth_;
      sum += length_(last, head) + sums[piece.end - 1] - sums[piece.begin];
      last = path_[piece.reversed ? piece.begin : piece.end - 1];
    }
    return behind < path_.size() ? sum + length_(last, path_[behind]) : sum;
  }

  void apply(std::size_t at, const std::array<Piece, 2>& pieces) {
    std::vector<int> nodes;
    for (const Piece& piece : pieces) {
      const std::size_t from = nodes.size();
      for (std::size_t p = piece.begin; p < piece.end; ++p) nodes.push_back(path_[p]);
      if (piece.reversed) std::reverse(nodes.begin() + static_cast<std::ptrdiff_t>(from), nodes.end());
    }
    std::copy(nodes.begin(), nodes.end(), path_.begin() + static_cast<std::ptrdiff_t>(at));
    measure();
  }

  void measure() {
    forth_.assign(path_.size(), 0);
    back_.assign(path_.size(), 0);
    for (std::size_t p = 1; p < path_.size(); ++p) {
      forth_[p] = forth_[p - 1] + length_(path_[p - 1], path_[p]);
      back_[p] = back_[p - 1] + length_(path_[p], path_[p - 1]);
    }
  }

  const Matrix& length_;
  std::vector<int> path_;
  std::vector<double> forth_, back_;  ///< from the path's begin to a node, and from it back
};

}  // namespace

double path_length(const Matrix& length, const std::vector<int>& path) {
  double sum = 0;
  for (std::size_t p = 1; p < path.size(); ++p) sum += length(path[p - 1], path[p]);
  return sum;
}

std::vector<int> three_opt(const Matrix& length, std::vector<int> path) {
  if (path.size() < 3) return path;
  MeasuredPath measured(length, std::move(path));
  while (measured.improve()) {
  }
  return measured.path();
}

std::vector<int> intra_cluster_path(const Matrix& length, int entry) {
  const int n = static_cast<int>(length.rows());
  ARPENT_ASSERT(entry >= 0 && entry < n);
  std::vector<int> path(static_cast<std::size_t>(n));
  std::iota(path.begin(), path.end(), 0);
  std::swap(path[0], path[static_cast<std::size_t>(entry)]);
  for (auto last = path.begin(); last + 1 < path.end(); ++last) {
    std::iter_swap(last + 1, std::min_element(last + 1, path.end(), [&](int a, int b) {
                     return std::pair(length(*last, a), a) < std::pair(length(*last, b), b);
                   }));
  }
  return three_opt(length, std::move(path));
}

}  // namespace arpent::tour
