// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/tsdf/surface_cells.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace arpent::mapping {
namespace {

/// A plane is accepted if its residuals are at most this many times the noise, in the root mean square, and it fits
/// every cell around within the same. Independent noise alone stays far below; steps of a few noise widths are found.
constexpr float kResidualNoises = 3.0F;
/// Relative deviation of inverse depth that is a plane's even without noise (curved surfaces, rounding to millimetres).
constexpr float kResidualRelative = 0.004F;
constexpr float kCellResidualNoises = 1.5F;  // of a cell's mean
constexpr float kMinCellPixels = 8;          // for such a mean
constexpr float kMinPixels = 60;             // of the 144 around a cell
constexpr float kMinCosine = 0.02F;

/// Sums over the valid pixels of a cell; u and v count from the cell's own corner.
struct Moments {
  float n = 0, u = 0, v = 0, uu = 0, uv = 0, vv = 0;
  float q = 0, uq = 0, vq = 0, qq = 0;  // q = 1 / z
  float noise2 = 0;                     // variance of q
};

/// Four floats of a row: a vector type of gcc and clang, which makes SSE or NEON of it.
using Row = float __attribute__((vector_size(16)));

Row load(const cv::Mat1f& image, int u, int v) {
  Row row;
  std::memcpy(&row, image.ptr<float>(v) + u, sizeof row);
  return row;
}

float sum(Row r) {
  return (r[0] + r[1]) + (r[2] + r[3]);
}

struct CellMeans {
  float n = 0, u = 0, v = 0, q = 0;
};

/// Adds `m`, whose pixels count from (du, dv).
void add_shifted(Moments& sum, const Moments& m, float du, float dv) {
  sum.n += m.n;
  sum.u += m.u + du * m.n;
  sum.v += m.v + dv * m.n;
  sum.uu += m.uu + 2 * du * m.u + du * du * m.n;
  sum.vv += m.vv + 2 * dv * m.v + dv * dv * m.n;
  sum.uv += m.uv + du * m.v + dv * m.u + du * dv * m.n;
  sum.q += m.q;
  sum.uq += m.uq + du * m.q;
  sum.vq += m.vq + dv * m.q;
  sum.qq += m.qq;
  sum.noise2 += m.noise2;
}

struct Fit {
  bool ok = false;
  float a = 0, b = 0, c = 0;  // q = a u + b v + c
  float rms = 0;
  float noise = 0;
};

/// Least squares of q = a u + b v + c.
Fit fit_plane(const Moments& m) {
  Fit fit;
  if (m.n < kMinPixels) return fit;
  const float inv = 1.0F / m.n;
  const float mu = m.u * inv;
  const float mv = m.v * inv;
  const float mq = m.q * inv;
  const float suu = m.uu * inv - mu * mu;
  const float suv = m.uv * inv - mu * mv;
  const float svv = m.vv * inv - mv * mv;
  const float suq = m.uq * inv - mu * mq;
  const float svq = m.vq * inv - mv * mq;
  const float sqq = m.qq * inv - mq * mq;
  const float det = suu * svv - suv * suv;
  if (det < 1.0F) return fit;
  fit.a = (svv * suq - suv * svq) / det;
  fit.b = (suu * svq - suv * suq) / det;
  fit.c = mq - fit.a * mu - fit.b * mv;
  fit.rms = std::sqrt(std::max(0.0F, sqq - fit.a * suq - fit.b * svq));
  fit.noise = std::sqrt(m.noise2 * inv);
  fit.ok = true;
  return fit;
}

class Fitter {
 public:
  Fitter(const stereo::DepthMap& depth, double min_range_m, double max_range_m)
      : depth_(depth), nearest_(static_cast<float>(min_range_m)), farthest_(static_cast<float>(max_range_m)) {
    cells_.cols = depth.depth_m.cols / kCellPx;
    cells_.rows = depth.depth_m.rows / kCellPx;
    const auto count = static_cast<std::size_t>(cells_.cols * cells_.rows);
    cells_.planes.resize(count);
    cells_.kinds.assign(count, CellKind::kNone);
    cells_.most_m.resize(count);
    moments_.resize(count);
    beside_.resize(count);
    means_.resize(count);
  }

  SurfaceCells run() {
    for (int v = 0; v < cells_.rows; ++v) {
      for (int u = 0; u < cells_.cols; ++u) gather(u, v);
      add_beside(v);
    }
    for (int v = 0; v < cells_.rows; ++v) {
      for (int u = 0; u < cells_.cols; ++u) fit(u, v);
    }
    return std::move(cells_);
  }

 private:
  /// Four pixels of a row at a time (bench `tsdf`: half of an integration's time at 0.1 m was here).
  void gather(int cell_u, int cell_v) {
    static_assert(kCellPx == 4);
    constexpr Row kColumn = {0, 1, 2, 3};
    const Row zero = {};
    Row n = {}, nv = {}, nvv = {}, q = {}, vq = {}, qq = {}, noise2 = {}, most = {};
    for (int v = 0; v < kCellPx; ++v) {
      const auto fv = static_cast<float>(v);
      const Row z = load(depth_.depth_m, kCellPx * cell_u, kCellPx * cell_v + v);
      const Row sigma = load(depth_.sigma_m, kCellPx * cell_u, kCellPx * cell_v + v);
      const auto valid = (z >= nearest_) & (z <= farthest_);  // false for NaN
      const Row one = valid ? zero + 1 : zero;
      const Row inverse = valid ? 1 / z : zero;
      const Row noise = valid ? sigma * inverse * inverse : zero;
      n += one;
      nv += fv * one;
      nvv += fv * fv * one;
      q += inverse;
      vq += fv * inverse;
      qq += inverse * inverse;
      noise2 += noise * noise;
      most = valid & (z > most) ? z : most;
    }
    const std::size_t at = cells_.at(cell_u, cell_v);
    moments_[at] = {.n = sum(n),
                    .u = sum(n * kColumn),
                    .v = sum(nv),
                    .uu = sum(n * kColumn * kColumn),
                    .uv = sum(nv * kColumn),
                    .vv = sum(nvv),
                    .q = sum(q),
                    .uq = sum(q * kColumn),
                    .vq = sum(vq),
                    .qq = sum(qq),
                    .noise2 = sum(noise2)};
    const float inv = 1.0F / std::max(moments_[at].n, 1.0F);
    means_[at] = {moments_[at].n, moments_[at].u * inv, moments_[at].v * inv, moments_[at].q * inv};
    cells_.most_m[at] = std::max({most[0], most[1], most[2], most[3]});
  }

  /// Sums of each cell and its neighbours to the left and right.
  void add_beside(int v) {
    for (int u = 0; u < cells_.cols; ++u) {
      Moments sum = moments_[cells_.at(u, v)];
      if (u > 0) add_shifted(sum, moments_[cells_.at(u - 1, v)], -kCellPx, 0);
      if (u + 1 < cells_.cols) add_shifted(sum, moments_[cells_.at(u + 1, v)], kCellPx, 0);
      beside_[cells_.at(u, v)] = sum;
    }
  }

  [[nodiscard]] float ray_x(int cell_u) const {
    return (static_cast<float>(kCellPx * cell_u) + 1.5F - static_cast<float>(depth_.camera.cx_px)) /
           static_cast<float>(depth_.camera.fx_px);
  }
  [[nodiscard]] float ray_y(int cell_v) const {
    return (static_cast<float>(kCellPx * cell_v) + 1.5F - static_cast<float>(depth_.camera.cy_px)) /
           static_cast<float>(depth_.camera.fy_px);
  }

  /// Mean residual of a cell against a plane in the coordinates of the cell that lies (-du, -dv) cells from it.
  [[nodiscard]] static float mean_residual(const Fit& fit, int du, int dv, const CellMeans& m) {
    return m.q - (fit.a * (m.u + static_cast<float>(kCellPx * du)) + fit.b * (m.v + static_cast<float>(kCellPx * dv)) +
                  fit.c);
  }

  void fit(int cell_u, int cell_v) {
    const std::size_t at = cells_.at(cell_u, cell_v);
    if (moments_[at].n == 0) return;
    cells_.kinds[at] = CellKind::kEdge;
    const int u0 = std::max(cell_u - 1, 0), u1 = std::min(cell_u + 1, cells_.cols - 1);
    const int v0 = std::max(cell_v - 1, 0), v1 = std::min(cell_v + 1, cells_.rows - 1);
    Moments sum = beside_[at];
    for (const int v : {v0, v1}) {
      if (v != cell_v) add_shifted(sum, beside_[cells_.at(cell_u, v)], 0, static_cast<float>(kCellPx * (v - cell_v)));
    }
    const Fit fit = fit_plane(sum);
    const float mean = sum.q / std::max(1.0F, sum.n);
    if (!fit.ok || fit.rms > kResidualNoises * fit.noise + kResidualRelative * mean) return;
    const float most = kCellResidualNoises * fit.noise + kResidualRelative * mean;
    for (int v = v0; v <= v1; ++v) {
      for (int u = u0; u <= u1; ++u) {
        const CellMeans& m = means_[cells_.at(u, v)];
        if (m.n < kMinCellPixels) continue;
        if (std::abs(mean_residual(fit, u - cell_u, v - cell_v, m)) > most) return;
      }
    }
    set_plane(at, fit, cell_u, cell_v);
  }

  /// q = a u + b v + c with pixels counted from the cell, as a plane in the camera's frame: with x = (u - cx) z / fx
  /// the plane is a fx x + b fy y + (a cx + b cy + c0) z = 1.
  void set_plane(std::size_t at, const Fit& fit, int cell_u, int cell_v) {
    const PinholeCamera& camera = depth_.camera;
    const float c0 =
        fit.c - fit.a * static_cast<float>(kCellPx * cell_u) - fit.b * static_cast<float>(kCellPx * cell_v);
    const float x = fit.a * static_cast<float>(camera.fx_px);
    const float y = fit.b * static_cast<float>(camera.fy_px);
    const float z = fit.a * static_cast<float>(camera.cx_px) + fit.b * static_cast<float>(camera.cy_px) + c0;
    const float length = std::sqrt(x * x + y * y + z * z);
    if (!(length > 1e-6F)) return;
    // Seen too flatly, the plane says nothing about distance.
    const float centre_u = ray_x(cell_u);
    const float centre_v = ray_y(cell_v);
    const float ray = std::sqrt(centre_u * centre_u + centre_v * centre_v + 1.0F);
    if ((x * centre_u + y * centre_v + z) / (length * ray) < kMinCosine) return;
    cells_.planes[at] = {-x / length, -y / length, -z / length, 1.0F / length};
    cells_.kinds[at] = CellKind::kPlane;
  }

  const stereo::DepthMap& depth_;
  float nearest_;
  float farthest_;
  SurfaceCells cells_;
  std::vector<Moments> moments_;
  std::vector<Moments> beside_;
  std::vector<CellMeans> means_;
};

}  // namespace

SurfaceCells fit_surface_cells(const stereo::DepthMap& depth, double min_range_m, double max_range_m) {
  return Fitter(depth, min_range_m, max_range_m).run();
}

}  // namespace arpent::mapping
