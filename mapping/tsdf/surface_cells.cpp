// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/tsdf/surface_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arpent::mapping {
namespace {

/// A plane is accepted if its residuals are at most this many times the noise, in the root mean square, and it fits
/// every cell around within the same. Independent noise alone stays far below; steps of a few noise widths are found.
constexpr float kResidualNoises = 3.0F;
/// Relative deviation of inverse depth that is a plane's even without noise (curved surfaces, rounding to millimetres).
constexpr float kResidualRelative = 0.004F;
constexpr float kMinPixels = 60;  // of the 144 around a cell
constexpr float kMinCosine = 0.02F;

/// Sums over the valid pixels of a cell; u and v count from the cell's own corner.
struct Moments {
  float n = 0, u = 0, v = 0, uu = 0, uv = 0, vv = 0;
  float q = 0, uq = 0, vq = 0, qq = 0;  // q = 1 / z
  float noise2 = 0;                     // variance of q
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
    cells_.least_m.resize(count);
    cells_.most_m.resize(count);
    cells_.holes.resize(count);
    moments_.resize(count);
  }

  SurfaceCells run() {
    for (int v = 0; v < cells_.rows; ++v) {
      for (int u = 0; u < cells_.cols; ++u) gather(u, v);
    }
    for (int v = 0; v < cells_.rows; ++v) {
      for (int u = 0; u < cells_.cols; ++u) fit(u, v);
    }
    return std::move(cells_);
  }

 private:
  void gather(int cell_u, int cell_v) {
    const std::size_t at = cells_.at(cell_u, cell_v);
    Moments m;
    float least = std::numeric_limits<float>::max();
    float most = 0;
    for (int v = 0; v < kCellPx; ++v) {
      const float* z_row = depth_.depth_m.ptr<float>(kCellPx * cell_v + v) + kCellPx * cell_u;
      const float* s_row = depth_.sigma_m.ptr<float>(kCellPx * cell_v + v) + kCellPx * cell_u;
      for (int u = 0; u < kCellPx; ++u) {
        const float z = z_row[u];
        const bool valid = z >= nearest_ && z <= farthest_;  // false for NaN
        const float one = valid ? 1.0F : 0.0F;
        const float q = valid ? 1.0F / z : 0.0F;
        const float noise = valid ? s_row[u] * q * q : 0.0F;
        const auto fu = static_cast<float>(u);
        const auto fv = static_cast<float>(v);
        m.n += one;
        m.u += one * fu;
        m.v += one * fv;
        m.uu += one * fu * fu;
        m.uv += one * fu * fv;
        m.vv += one * fv * fv;
        m.q += q;
        m.uq += fu * q;
        m.vq += fv * q;
        m.qq += q * q;
        m.noise2 += noise * noise;
        least = valid ? std::min(least, z) : least;
        most = valid ? std::max(most, z) : most;
      }
    }
    moments_[at] = m;
    cells_.least_m[at] = least;
    cells_.most_m[at] = most;
    cells_.holes[at] = m.n < kCellPx * kCellPx ? 1 : 0;
  }

  /// Mean residual of the cell (u, v) against a plane in the coordinates of cell (u0, v0).
  [[nodiscard]] float mean_residual(const Fit& fit, int du, int dv, const Moments& m) const {
    return m.q / m.n - (fit.a * (m.u / m.n + static_cast<float>(kCellPx * du)) +
                        fit.b * (m.v / m.n + static_cast<float>(kCellPx * dv)) + fit.c);
  }

  void fit(int cell_u, int cell_v) {
    const std::size_t at = cells_.at(cell_u, cell_v);
    if (moments_[at].n == 0) return;
    cells_.kinds[at] = CellKind::kEdge;
    Moments sum;
    const int u0 = std::max(cell_u - 1, 0), u1 = std::min(cell_u + 1, cells_.cols - 1);
    const int v0 = std::max(cell_v - 1, 0), v1 = std::min(cell_v + 1, cells_.rows - 1);
    for (int v = v0; v <= v1; ++v) {
      for (int u = u0; u <= u1; ++u) {
        add_shifted(sum, moments_[cells_.at(u, v)], static_cast<float>(kCellPx * (u - cell_u)),
                    static_cast<float>(kCellPx * (v - cell_v)));
      }
    }
    const Fit fit = fit_plane(sum);
    const float mean = sum.q / std::max(1.0F, sum.n);
    if (!fit.ok || fit.rms > kResidualNoises * fit.noise + kResidualRelative * mean) return;
    for (int v = v0; v <= v1; ++v) {
      for (int u = u0; u <= u1; ++u) {
        const Moments& m = moments_[cells_.at(u, v)];
        if (m.n < 8) continue;
        if (std::abs(mean_residual(fit, u - cell_u, v - cell_v, m)) > 1.5F * fit.noise + kResidualRelative * mean)
          return;
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
    const float centre_u = (static_cast<float>(kCellPx * cell_u) + 1.5F - static_cast<float>(camera.cx_px)) /
                           static_cast<float>(camera.fx_px);
    const float centre_v = (static_cast<float>(kCellPx * cell_v) + 1.5F - static_cast<float>(camera.cy_px)) /
                           static_cast<float>(camera.fy_px);
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
};

}  // namespace

SurfaceCells fit_surface_cells(const stereo::DepthMap& depth, double min_range_m, double max_range_m) {
  return Fitter(depth, min_range_m, max_range_m).run();
}

}  // namespace arpent::mapping
