// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/edges.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace arpent::tags {
namespace {

using Eigen::Vector2d;

constexpr double kCellsPerSide = 8;  // of family 36h11, within the white rim
constexpr double kMinCellPx = 1.6;
constexpr double kMaxHalfWidthPx = 3.5;
constexpr double kStepAcrossPx = 0.25;
constexpr double kMinContrast = 20;  // grey levels between the black square and its rim
constexpr int kMinSamples = 8;
constexpr double kMinSupport = 0.75;  // share of a side's samples that lie on its line
constexpr double kMinGatePx = 0.15;
constexpr int kPasses = 4;
constexpr double kConvergedPx = 0.005;
/// Samples one pixel apart share pixels: their errors are worth this many times fewer independent ones.
constexpr double kSharing = 1.5;
/// What a line is off although its samples agree, measured on pictures without noise: with windows that hold the whole
/// blurred edge, and with the square of the share of the contrast that lies in the outer thirds of a window that does
/// not.
constexpr double kFloorPx = 0.008;
constexpr double kLeakPx = 3.0;

/// y = a + b x by least squares, over the entries whose `used` is true.
struct Line1 {
  double a = 0, b = 0;
  [[nodiscard]] double at(double x) const { return a + b * x; }
};

Line1 fit(const std::vector<double>& x, const std::vector<double>& y, const std::vector<bool>& used) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!used[i]) continue;
    n += 1, sx += x[i], sy += y[i], sxx += x[i] * x[i], sxy += x[i] * y[i];
  }
  const double determinant = n * sxx - sx * sx;
  if (n < 2 || determinant <= 0) return {};
  const double b = (n * sxy - sx * sy) / determinant;
  return {(sy - b * sx) / n, b};
}

/// Bilinear.
double grey(const cv::Mat1b& image, const Vector2d& p) {
  const int u = static_cast<int>(std::floor(p.x()));
  const int v = static_cast<int>(std::floor(p.y()));
  const double s = p.x() - u;
  const double t = p.y() - v;
  return (1 - t) * ((1 - s) * image(v, u) + s * image(v, u + 1)) +
         t * ((1 - s) * image(v + 1, u) + s * image(v + 1, u + 1));
}

bool is_inside(const cv::Mat1b& image, const Vector2d& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() < image.cols - 1 && p.y() < image.rows - 1;
}

/// The stretch of one side along which profiles are taken.
struct Stretch {
  Vector2d start, along, normal;
  double length_px = 0;
  double half_width_px = 0;
  double margin_px = 0;  ///< left out at both ends, where the next side blurs in
};

std::optional<Stretch> stretch_of(const ImageCorners& corners, std::size_t k) {
  const Vector2d a = corners[k];
  const Vector2d b = corners[(k + 1) % 4];
  const Vector2d before = corners[(k + 3) % 4] - a;
  const Vector2d after = corners[(k + 2) % 4] - b;
  Stretch s;
  s.start = a;
  s.length_px = (b - a).norm();
  if (!(s.length_px > kCellsPerSide)) return std::nullopt;
  s.along = (b - a) / s.length_px;
  s.normal = Vector2d(-s.along.y(), s.along.x());
  // Corners run counter-clockwise as one looks at the tag; in image axes (v down) this normal then points outwards.
  const double depth_px = std::min(-s.normal.dot(before), -s.normal.dot(after));
  const double cell_px = depth_px / kCellsPerSide;
  if (!(cell_px >= kMinCellPx)) return std::nullopt;
  s.half_width_px = std::min(0.5 * cell_px, kMaxHalfWidthPx);
  s.margin_px = std::max(0.5 * s.length_px / kCellsPerSide, 1.5);
  return s;
}

/// Per sample along a side: mean grey across it and in the outer third of its dark and its bright half; and the mean
/// rise within these thirds, which are level if the window holds the whole edge.
struct Profiles {
  std::vector<double> along_px, mean, dark, bright;
  double dark_rise = 0, bright_rise = 0;
};

std::optional<Profiles> sample(const cv::Mat1b& image, const Stretch& s) {
  const int inner = 2 * static_cast<int>(std::ceil(s.half_width_px / (3 * kStepAcrossPx)));
  const int across = inner / 2 * 3;
  const int ends = across - inner + 1;
  const double step_px = s.half_width_px / across;
  Profiles profiles;
  for (double x = s.margin_px; x <= s.length_px - s.margin_px; x += 1.0) {
    const Vector2d centre = s.start + x * s.along;
    const Vector2d reach = s.half_width_px * s.normal;
    if (!is_inside(image, centre - reach) || !is_inside(image, centre + reach)) return std::nullopt;
    const auto at = [&](int i) { return grey(image, centre + i * step_px * s.normal); };
    double sum = 0, dark = 0, bright = 0;
    for (int i = -across; i <= across; ++i) {
      const double g = at(i);
      sum += std::abs(i) == across ? 0.5 * g : g;  // trapezoidal rule
      if (std::abs(i) >= inner) (i < 0 ? dark : bright) += g;
    }
    profiles.dark_rise += at(-inner) - at(-across);
    profiles.bright_rise += at(across) - at(inner);
    profiles.along_px.push_back(x);
    profiles.mean.push_back(sum / (2 * across));
    profiles.dark.push_back(dark / ends);
    profiles.bright.push_back(bright / ends);
  }
  const auto samples = static_cast<double>(profiles.mean.size());
  if (samples < kMinSamples) return std::nullopt;
  profiles.dark_rise /= samples;
  profiles.bright_rise /= samples;
  return profiles;
}

/// How far outwards the edge lies from the stretch, per sample: a step from dark to bright at t has the mean
/// (dark + bright) / 2 - t / half width * (bright - dark) / 2. The levels are lines along the side, so that a shade
/// that grows along it shifts nothing. Empty without contrast.
struct EdgeOffsets {
  std::vector<double> px;
  double leak = 0;  ///< share of the contrast that lies in the window's outer thirds
};

EdgeOffsets edge_offsets(const Profiles& p, double half_width_px) {
  const std::vector<bool> all(p.mean.size(), true);
  const Line1 dark = fit(p.along_px, p.dark, all);
  const Line1 bright = fit(p.along_px, p.bright, all);
  EdgeOffsets offsets;
  double contrast = 0;
  for (std::size_t i = 0; i < p.mean.size(); ++i) {
    const double low = dark.at(p.along_px[i]);
    const double high = bright.at(p.along_px[i]);
    if (high - low < kMinContrast) return {};
    offsets.px.push_back(half_width_px * (0.5 * (low + high) - p.mean[i]) / (0.5 * (high - low)));
    contrast += (high - low) / static_cast<double>(p.mean.size());
  }
  offsets.leak = (std::abs(p.dark_rise) + std::abs(p.bright_rise)) / contrast;
  return offsets;
}

/// A line through the offsets, without those that are off it by more than 3 deviations (by the median).
struct RobustLine {
  Line1 line;
  double deviation_px = 0;
  int used = 0;
};

RobustLine fit_robust(const std::vector<double>& x, const std::vector<double>& y) {
  RobustLine result;
  std::vector<bool> used(x.size(), true);
  for (int pass = 0; pass < 3; ++pass) {
    result.line = fit(x, y, used);
    std::vector<double> residuals;
    for (std::size_t i = 0; i < x.size(); ++i) residuals.push_back(std::abs(y[i] - result.line.at(x[i])));
    std::vector<double> sorted = residuals;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double gate_px = std::max(kMinGatePx, 3 * 1.4826 * sorted[sorted.size() / 2]);
    double squares = 0;
    result.used = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      used[i] = residuals[i] <= gate_px;
      result.used += used[i];
      squares += used[i] ? residuals[i] * residuals[i] : 0;
    }
    result.deviation_px = std::sqrt(squares / std::max(1, result.used - 2));
  }
  return result;
}

std::optional<TagSide> fit_side(const cv::Mat1b& image, const ImageCorners& corners, std::size_t k) {
  const auto stretch = stretch_of(corners, k);
  if (!stretch) return std::nullopt;
  const auto profiles = sample(image, *stretch);
  if (!profiles) return std::nullopt;
  const EdgeOffsets offsets = edge_offsets(*profiles, stretch->half_width_px);
  if (offsets.px.empty()) return std::nullopt;
  const RobustLine fitted = fit_robust(profiles->along_px, offsets.px);
  if (fitted.used < kMinSupport * static_cast<double>(offsets.px.size())) return std::nullopt;
  const Vector2d a = stretch->start + fitted.line.a * stretch->normal;
  const Vector2d b =
      stretch->start + stretch->length_px * stretch->along + fitted.line.at(stretch->length_px) * stretch->normal;
  TagSide side;
  const Vector2d along = (b - a).normalized();
  side.normal = Vector2d(-along.y(), along.x());
  side.offset_px = side.normal.dot(a);
  // Ends of a line through n evenly spread samples: variance 4 s^2 / n, covariance -2 s^2 / n.
  const double v = kSharing * fitted.deviation_px * fitted.deviation_px / fitted.used;
  side.covariance_px2 << 4 * v, -2 * v, -2 * v, 4 * v;
  const double floor_px = kFloorPx + kLeakPx * offsets.leak * offsets.leak;
  side.covariance_px2.diagonal().array() += floor_px * floor_px;
  return side;
}

/// nullopt if two neighbouring sides are nearly parallel.
std::optional<ImageCorners> intersect(const std::array<TagSide, 4>& sides) {
  ImageCorners corners;
  for (std::size_t k = 0; k < 4; ++k) {
    const TagSide& before = sides[(k + 3) % 4];
    const TagSide& after = sides[k];
    Eigen::Matrix2d N;
    N << before.normal.transpose(), after.normal.transpose();
    if (std::abs(N.determinant()) < 0.1) return std::nullopt;
    corners[k] = N.inverse() * Vector2d(before.offset_px, after.offset_px);
  }
  return corners;
}

}  // namespace

std::optional<TagOutline> fit_outline(const cv::Mat1b& image, const ImageCorners& corners_px) {
  TagOutline outline;
  outline.corners_px = corners_px;
  for (int pass = 0; pass < kPasses; ++pass) {
    for (std::size_t k = 0; k < 4; ++k) {
      const auto side = fit_side(image, outline.corners_px, k);
      if (!side) return std::nullopt;
      outline.sides[k] = *side;
    }
    const auto corners = intersect(outline.sides);
    if (!corners) return std::nullopt;
    double moved_px = 0;
    for (std::size_t k = 0; k < 4; ++k) moved_px = std::max(moved_px, ((*corners)[k] - outline.corners_px[k]).norm());
    outline.corners_px = *corners;
    if (moved_px < kConvergedPx) break;
  }
  return outline;
}

}  // namespace arpent::tags
