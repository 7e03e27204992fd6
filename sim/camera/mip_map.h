// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A repeating picture at all sizes: what a pixel sees of a texture is its mean over the pixel's footprint, without
// aliasing. Values are 16-bit so that eight lanes of a row of a picture fit the cache.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

namespace arpent::sim {

class MipMap {
 public:
  /// width x height values, powers of two, row by row. They are kept with 16 bits over [lowest, highest].
  MipMap(int width, int height, const std::vector<float>& values);

  /// Level 0 is the picture itself, each further one half as wide.
  [[nodiscard]] int levels() const { return static_cast<int>(levels_.size()); }
  [[nodiscard]] int width() const { return levels_.front().width; }
  [[nodiscard]] int height() const { return levels_.front().height; }

  /// Eight values at (u, v), 1 is the whole picture, at a level between 0 and levels() - 1: linear between texels and
  /// between levels. Coordinates outside [0, 1] repeat.
  void sample(const std::array<float, 8>& u, const std::array<float, 8>& v, float level,
              std::array<float, 8>& values) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    int stride = 0;  ///< one column (and row) more than the picture: the first once more
    std::vector<std::uint16_t> texels;
  };
  static void sample_level(const Level& level, const std::array<float, 8>& u, const std::array<float, 8>& v,
                           std::array<float, 8>& values);

  float scale_ = 1;
  float lowest_ = 0;
  std::vector<Level> levels_;
};

}  // namespace arpent::sim
