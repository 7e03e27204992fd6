// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Which tags of an AprilGrid are in an image, and about where their corners are.
#pragma once

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/target.h"

namespace arpent::calib {

/// Bottom left, bottom right, top right, top left of the black square [px].
using ImageQuad = std::array<Eigen::Vector2d, 4>;

struct GridTag {
  int number = 0;  ///< of the board: Target's row * columns + column
  ImageQuad quad;  ///< to about a pixel
};

class TagSearch {
 public:
  explicit TagSearch(const Target& target);
  ~TagSearch();

  /// By number, each at most once. Tags that do not lie where the others say are left out.
  [[nodiscard]] std::vector<GridTag> find(const cv::Mat1b& image) const;

 private:
  struct Library;
  [[nodiscard]] std::vector<GridTag> run_library(const cv::Mat1b& image) const;
  [[nodiscard]] bool carries_tag(const cv::Mat1b& image, int number, const ImageQuad& quad) const;
  [[nodiscard]] std::vector<GridTag> add_missed(const cv::Mat1b& image, std::vector<GridTag> found) const;

  Target target_;
  std::unique_ptr<Library> library_;
  std::vector<std::vector<bool>> black_cells_;  ///< of each tag, row by row from the top
};

}  // namespace arpent::calib
