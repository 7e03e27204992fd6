// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation/legal_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/camera/tracer.h"
#include "tools/evaluation/reach.h"

namespace arpent::evaluation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Lines of sight to a surface end this far in front of it.
constexpr double kAheadM = 0.003;

double yaw_of(int heading) {
  return wrap_angle(2 * std::numbers::pi * heading / LegalViews::kHeadings);
}

/// A place of the left camera, with the headings that the body can have there.
struct Station {
  Vector3d camera_m;
  std::uint32_t headings = 0;
};

/// Up to eight lines of sight, tested together.
class SightLines {
 public:
  explicit SightLines(const sim::Tracer& tracer) : tracer_(tracer) {}

  void add(const Vector3d& from, const Vector3d& to, int tag) {
    const Vector3d d = to - from;
    for (std::size_t k = 0; k < 3; ++k) {
      packet_.origin[k][size_] = static_cast<float>(from[static_cast<Eigen::Index>(k)]);
      packet_.direction[k][size_] = static_cast<float>(d[static_cast<Eigen::Index>(k)]);
    }
    tags_[size_++] = tag;
  }
  [[nodiscard]] bool full() const { return size_ == sim::kLanes; }
  /// Calls clear(tag) for each line that meets nothing, and begins anew.
  template <class Clear>
  void test(const Clear& clear) {
    for (std::size_t i = 0; i < sim::kLanes; ++i) packet_.t[i] = i < size_ ? 1.0F : -1.0F;
    tracer_.find_occluded(packet_);
    for (std::size_t i = 0; i < size_; ++i) {
      if (packet_.facet[i] < 0) clear(tags_[i]);
    }
    size_ = 0;
  }

 private:
  const sim::Tracer& tracer_;
  sim::RayPacket packet_{};
  std::array<int, sim::kLanes> tags_{};
  std::size_t size_ = 0;
};

}  // namespace

struct LegalViews::State {
  LegalViewParams params;
  Reach reach;
  sim::Tracer tracer;
  std::array<Vector2d, kHeadings> forward;
  std::vector<Station> stations;
  std::vector<std::vector<int>> cells;  ///< stations in squares of kCellM
  Vector2d corner_m;
  int columns = 0, rows = 0;
  std::size_t poses = 0;
  double cos_limit;
  double reach_m;
  mutable int last_station = -1;  ///< that saw something: it is likely to see what lies beside it

  State(const sim::World& world, const Pose2& start, const LegalViewParams& p)
      : params(p),
        reach(world, start, p.footprint, p.step_m, kHeadings),
        tracer(sim::make_surface_mesh(world)),
        cos_limit(std::cos(p.max_incidence_deg * std::numbers::pi / 180)),
        reach_m(p.camera.max_range_m * std::hypot(1.0, std::max(p.camera.left_slope, p.camera.right_slope))) {
    for (int h = 0; h < kHeadings; ++h)
      forward[static_cast<std::size_t>(h)] = {std::cos(yaw_of(h)), std::sin(yaw_of(h))};
    make_stations(world.region);
    sort_into_cells();
  }

  void make_stations(const sim::Region& region) {
    const double margin_m = params.camera.p_body_m.head<2>().norm();
    corner_m = region.min_m.head<2>().array() - margin_m;
    const Vector2d size_m = region.max_m.head<2>() - region.min_m.head<2>() + Vector2d::Constant(2 * margin_m);
    columns = static_cast<int>(std::ceil(size_m.x() / reach_m));
    rows = static_cast<int>(std::ceil(size_m.y() / reach_m));
    for (int y = 0; y * params.view_m <= size_m.y(); ++y) {
      for (int x = 0; x * params.view_m <= size_m.x(); ++x) {
        const Vector2d p = corner_m + params.view_m * Vector2d(x, y);
        Station station{{p.x(), p.y(), params.camera.p_body_m.z()}};
        for (int h = 0; h < kHeadings; ++h) {
          if (!reach.contains(body_at(p, yaw_of(h)))) continue;
          station.headings |= 1U << h;
          ++poses;
        }
        if (station.headings != 0) stations.push_back(station);
      }
    }
  }

  /// The body whose left camera is here.
  [[nodiscard]] Pose2 body_at(const Vector2d& camera_m, double yaw_rad) const {
    const Vector3d offset = params.camera.position_m({0, 0, yaw_rad});
    return {camera_m.x() - offset.x(), camera_m.y() - offset.y(), yaw_rad};
  }

  void sort_into_cells() {
    cells.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    for (std::size_t i = 0; i < stations.size(); ++i) {
      const auto cell = cell_of(stations[i].camera_m);
      cells[index_of(std::min(cell.x(), columns - 1), std::min(cell.y(), rows - 1))].push_back(static_cast<int>(i));
    }
  }
  [[nodiscard]] Eigen::Vector2i cell_of(const Vector3d& p) const {
    return ((p.head<2>() - corner_m) / reach_m).array().floor().cast<int>();
  }
  [[nodiscard]] std::size_t index_of(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
  }

  /// How many of the station's headings have the point in both images, within range.
  [[nodiscard]] int headings_with(const Station& station, const Vector3d& p) const {
    const planning::LevelCamera& c = params.camera;
    const Vector2d d = p.head<2>() - station.camera_m.head<2>();
    const double up = p.z() - station.camera_m.z();
    if (d.squaredNorm() > reach_m * reach_m) return 0;
    int count = 0;
    for (int h = 0; h < kHeadings; ++h) {
      if ((station.headings >> h & 1U) == 0) continue;
      const Vector2d& f = forward[static_cast<std::size_t>(h)];
      const double depth = f.dot(d), right = f.y() * d.x() - f.x() * d.y();
      const bool inside = depth >= c.min_range_m && depth <= c.max_range_m && right <= c.right_slope * depth &&
                          right - c.baseline_m >= -c.left_slope * depth && up <= c.up_slope * depth &&
                          up >= -c.down_slope * depth;
      count += inside ? 1 : 0;
    }
    return count;
  }

  /// Calls visit(station) for all within reach until it returns true.
  template <class Visit>
  bool any_near(const Vector3d& p, const Visit& visit) const {
    const Eigen::Vector2i centre = cell_of(p);
    for (int row = std::max(0, centre.y() - 1); row <= std::min(rows - 1, centre.y() + 1); ++row) {
      for (int column = std::max(0, centre.x() - 1); column <= std::min(columns - 1, centre.x() + 1); ++column) {
        for (const int i : cells[index_of(column, row)]) {
          if (visit(i)) return true;
        }
      }
    }
    return false;
  }

  /// Along its middle and its four sides.
  [[nodiscard]] bool has_clear_beam(const Vector3d& from, const Vector3d& to, double stop_short_m,
                                    double beam_m) const {
    const Vector3d d = to - from, end = from + std::max(0.0, 1 - stop_short_m / d.norm()) * d;
    const Vector3d side = beam_m * d.cross(Vector3d::UnitZ()).normalized(), up = beam_m * side.cross(d).normalized();
    SightLines lines(tracer);
    lines.add(from, end, 0);
    int added = 1, clear = 0;
    if (beam_m > 0) {
      for (const Vector3d& offset : {side, Vector3d(-side), up, Vector3d(-up)}) {
        lines.add(from + offset, end + offset, added++);
      }
    }
    lines.test([&](int) { ++clear; });
    return clear == added;
  }

  /// The end of the line of sight from a station to a piece of surface, unless it is seen at too flat an angle.
  [[nodiscard]] std::optional<Vector3d> target(const Station& station, const Vector3d& p, const Vector3d& n) const {
    const Vector3d d = station.camera_m - p;
    const double along = n.dot(d);
    if (std::abs(along) < cos_limit * d.norm()) return std::nullopt;
    return p + std::copysign(kAheadM, along) * n;
  }
};

LegalViews::LegalViews(const sim::World& world, const Pose2& start, const LegalViewParams& params)
    : state_(std::make_unique<State>(world, start, params)) {}
LegalViews::~LegalViews() = default;
LegalViews::LegalViews(LegalViews&&) noexcept = default;
LegalViews& LegalViews::operator=(LegalViews&&) noexcept = default;

const LegalViewParams& LegalViews::params() const {
  return state_->params;
}

std::size_t LegalViews::pose_count() const {
  return state_->poses;
}

bool LegalViews::is_reachable(const Pose2& body) const {
  return state_->reach.contains(body);
}

bool LegalViews::see(const Vector3d& p, const Vector3d& normal) const {
  const State& s = *state_;
  SightLines lines(s.tracer);
  bool seen = false;
  const auto clear = [&](int station) {
    seen = true;
    s.last_station = station;
  };
  const auto consider = [&](int i) {
    const Station& station = s.stations[static_cast<std::size_t>(i)];
    if (s.headings_with(station, p) == 0) return false;
    if (const auto to = s.target(station, p, normal)) lines.add(station.camera_m, *to, i);
    if (lines.full()) lines.test(clear);
    return seen;
  };
  if (s.last_station >= 0) consider(s.last_station);
  lines.test(clear);
  if (seen || s.any_near(p, consider)) return true;
  lines.test(clear);
  return seen;
}

LegalViews::Count LegalViews::count(const Vector3d& p, double stop_short_m, double beam_m) const {
  const State& s = *state_;
  Count count;
  s.any_near(p, [&](int i) {
    const Station& station = s.stations[static_cast<std::size_t>(i)];
    const int headings = s.headings_with(station, p);
    if (headings == 0) return false;
    count.in_view += headings;
    if (s.has_clear_beam(station.camera_m, p, stop_short_m, beam_m)) count.in_sight += headings;
    return false;
  });
  return count;
}

bool LegalViews::in_line_of_sight(const Vector3d& from_m, const Vector3d& p, double stop_short_m) const {
  return state_->has_clear_beam(from_m, p, stop_short_m, 0);
}

}  // namespace arpent::evaluation
