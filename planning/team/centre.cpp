// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/team/centre.h"

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <unordered_set>

#include "common/config/config.h"
#include "mapping/tsdf/storage.h"
#include "planning/local/obstacles.h"
#include "planning/mission/ground_free_space.h"
#include "planning/team/traffic.h"

namespace arpent::planning {
namespace {

/// Viewpoints that were sent are remembered, to know what a report speaks of.
constexpr std::size_t kRemembered = 400;
/// A visit counts once its pictures are in the map; if they do not come, after so long.
constexpr Duration kVisitWaits = std::chrono::seconds(5);
/// A viewpoint of which so much is completed by what a robot is on its way to is not given out.
constexpr double kHeldShare = 0.6;
/// So often in a row nothing is left before the team is done.
constexpr int kSureTimes = 3;
/// At the start robots first see where they are.
constexpr Duration kLeastMission = std::chrono::seconds(8);

using VoxelSet = std::unordered_set<VoxelIndex, mapping::BlockHash>;

/// Free for one is free for all; near is what is near to anybody.
class TeamFreeSpace : public FreeSpace {
 public:
  using Barred = std::function<bool(const Pose2&)>;

  TeamFreeSpace(const Ground& ground, const GroundGrid& grid, std::vector<Pose2> robots, Barred barred, bool turnable)
      : ground_(ground),
        space_(ground, grid, none_, robots.front(), turnable),
        robots_(std::move(robots)),
        barred_(std::move(barred)) {}

  [[nodiscard]] bool is_free(const Pose2& pose) const override { return space_.is_free(pose) && !barred_(pose); }

  /// From the first robot stands for: from whichever is nearest.
  [[nodiscard]] std::vector<std::optional<double>> distances_m(const Pose2& from, std::span<const Pose2> to,
                                                               double max_m) const override {
    std::vector<std::optional<double>> least = drive_lengths_m(ground_, from, to, max_m);
    if (!(from == robots_.front())) return least;
    for (std::size_t r = 1; r < robots_.size(); ++r) {
      const auto other = drive_lengths_m(ground_, robots_[r], to, max_m);
      for (std::size_t i = 0; i < least.size(); ++i) {
        if (other[i] && (!least[i] || *other[i] < *least[i])) least[i] = other[i];
      }
    }
    return least;
  }

 private:
  const Ground& ground_;
  UnreachableGoals none_;
  GroundFreeSpace space_;
  std::vector<Pose2> robots_;
  Barred barred_;
};

}  // namespace

struct Centre::State {
  struct Member {
    RobotState state;
    Time heard_at;
    bool begun = false;  ///< its start is declared free
    std::int64_t patches = 0;
    Time newest_patch{};
    std::int64_t sent = -1;  ///< number of the last tour
    std::size_t sent_viewpoints = 0;
  };
  struct Visit {
    TourReport report;
    Time heard_at;
  };
  struct Barred {
    Pose2 pose;
    int times = 0;
    Time until;
  };

  CentreParams params;
  mapping::TsdfMap map;
  ExplorationTargets targets;
  GroundGrid grid;
  Footprint footprint, body;
  mapping::PatchLedger ledger;
  std::map<std::string, Member> members;
  std::deque<Viewpoint> remembered;
  std::vector<Visit> visits;
  std::vector<Barred> barred;
  std::vector<std::pair<Time, TeamTour>> due;
  CentreStatus status;
  std::int64_t number = 0;
  std::optional<Time> first_running, planned_at;
  int nothing_left = 0;
  int known_lost = 0;

  State(const CentreParams& p, const LevelCamera& camera)
      : params(p),
        map(p.tsdf),
        targets(p.viewpoints, camera, box_between(p.region_min_m, p.region_max_m)),
        grid(p.grid),
        footprint(p.footprint.grown(planning_margin_m(p.footprint_margin_m, p.tsdf.voxel_m))),
        body(p.footprint) {}

  Result<std::size_t> take(const mapping::MapPatch& patch) {
    if (!ledger.add(patch.source, patch.sequence)) return std::size_t{0};
    auto fused = mapping::fuse(map, patch);
    if (!fused) return fused;
    targets.update(map);
    targets.note_looks(map, patch.bodies);
    ++status.patches;
    Member& member = members[patch.source];
    ++member.patches;
    if (!patch.bodies.empty()) member.newest_patch = std::max(member.newest_patch, patch.newest);
    return fused;
  }

  void take(const RobotState& state, Time now) {
    Member& member = members[state.robot];
    if (member.begun && state.stamp <= member.state.stamp) return;
    member.state = state;
    member.heard_at = now;
    if (!member.begun) {
      grid.declare_free(state.body.position_m(), params.start_clearance_m);
      grid.declare_body(body, state.body);
    }
    member.begun = true;
    if (state.state == MissionState::kRunning && !first_running) first_running = now;
  }

  [[nodiscard]] bool is_running(const Member& member, Time now) const {
    return member.begun && member.state.state == MissionState::kRunning && !is_lost(member, now);
  }
  [[nodiscard]] bool is_lost(const Member& member, Time now) const {
    return member.begun && now - member.heard_at > from_seconds(params.silent_s);
  }

  std::vector<TeamTour> step(Time now) {
    note_visits(now);
    std::vector<Member*> running;
    status.lost = 0;
    for (auto& [name, member] : members) {
      if (is_running(member, now)) running.push_back(&member);
      status.lost += is_lost(member, now) ? 1 : 0;
    }
    status.running = static_cast<int>(running.size());
    if (!running.empty() && wants_plan(running, now)) plan(running, now);
    return take_due(now);
  }

  void note_visits(Time now) {
    std::erase_if(visits, [&](const Visit& visit) {
      const bool arrived = members[visit.report.robot].newest_patch >= visit.report.stamp;
      if (!arrived && now - visit.heard_at < kVisitWaits) return false;
      if (const Viewpoint* viewpoint = find(visit.report.event.target)) targets.note_visit(map, *viewpoint);
      return true;
    });
  }

  /// A viewpoint that was sent.
  [[nodiscard]] const Viewpoint* find(const Pose2& pose) const {
    const auto found = std::find_if(remembered.rbegin(), remembered.rend(),
                                    [&](const Viewpoint& v) { return same_goal(v.pose, pose); });
    return found == remembered.rend() ? nullptr : &*found;
  }

  void take(const TourReport& report, Time now) {
    if (report.event.kind == TargetEvent::Kind::kVisited) {
      visits.push_back({report, now});
      return;
    }
    auto held = std::find_if(barred.begin(), barred.end(),
                             [&](const Barred& b) { return same_goal(b.pose, report.event.target); });
    if (held == barred.end()) held = barred.insert(barred.end(), {report.event.target, 0, now});
    ++held->times;
    held->until = now + from_seconds(params.unreachable_s);
  }

  [[nodiscard]] bool is_barred(const Pose2& pose, Time now) const {
    return std::any_of(barred.begin(), barred.end(), [&](const Barred& b) {
      return same_goal(b.pose, pose) && (b.times >= params.unreachable_times || now < b.until);
    });
  }

  [[nodiscard]] bool wants_plan(const std::vector<Member*>& running, Time now) const {
    if (!planned_at || status.lost != known_lost) return true;
    const bool waits = std::any_of(running.begin(), running.end(), [](const Member* m) {
      return m->state.idle && (m->state.tour >= m->sent || m->sent_viewpoints == 0);
    });
    return now - *planned_at >= from_seconds(waits ? params.early_replan_s : params.replan_s);
  }

  void plan(const std::vector<Member*>& running, Time now) {
    planned_at = now;
    known_lost = status.lost;
    ++status.plans;
    grid.update(map);
    std::vector<Pose2> bodies, robots;
    for (const auto& [name, member] : members) {
      if (!is_lost(member, now)) continue;
      const std::vector<Pose2> places = resting_places(member.state.body, member.state.twist);
      bodies.insert(bodies.end(), places.begin(), places.end());
    }
    std::vector<RobotPlace> places;
    VoxelSet held;
    std::vector<std::optional<Viewpoint>> committed;
    for (const Member* member : running) {
      robots.push_back(member->state.body);
      committed.push_back(committed_of(*member));
      places.push_back(place_of(*member, committed.back()));
      if (committed.back()) held.insert(committed.back()->elements.begin(), committed.back()->elements.end());
    }
    const Ground ground =
        ground_with_bodies(grid, footprint, params.costs, bodies, body, params.body_gap_m, robots.front());
    std::vector<Cluster> clusters = find_clusters(ground, robots, now);
    drop_held(clusters, held);
    status.elements = targets.surface().size();
    status.clusters = static_cast<int>(clusters.size());
    const VisitTimes times{params.nominal_speed_mps, params.nominal_turn_rate_radps, params.visit_s};
    const auto given = allocate(ground, clusters, places, params.allocation, times);
    note_whether_done(running, clusters.empty(), now);
    for (std::size_t r = 0; r < running.size(); ++r) send(*running[r], committed[r], given[r], now);
  }

  [[nodiscard]] std::vector<Cluster> find_clusters(const Ground& ground, const std::vector<Pose2>& robots, Time now) {
    for (const bool turnable : {true, false}) {
      const TeamFreeSpace space(
          ground, grid, robots, [&](const Pose2& pose) { return is_barred(pose, now); }, turnable);
      Targets found = targets.plan(map, space, robots.front());
      if (!found.clusters.empty()) return std::move(found.clusters);
    }
    return {};
  }

  /// What a robot is on its way to, or looks from, as long as it is worth it.
  [[nodiscard]] std::optional<Viewpoint> committed_of(const Member& member) const {
    if (!member.state.target) return std::nullopt;
    const Viewpoint* viewpoint = find(*member.state.target);
    if (viewpoint == nullptr) return std::nullopt;
    const bool open = std::any_of(viewpoint->elements.begin(), viewpoint->elements.end(),
                                  [&](const VoxelIndex& v) { return targets.surface().contains(v); });
    return open ? std::optional(*viewpoint) : std::nullopt;
  }

  [[nodiscard]] RobotPlace place_of(const Member& member, const std::optional<Viewpoint>& committed) const {
    if (!committed) return {member.state.body, 0};
    const double way_m = (committed->pose.position_m() - member.state.body.position_m()).norm();
    return {committed->pose, way_m / params.nominal_speed_mps + params.visit_s};
  }

  static void drop_held(std::vector<Cluster>& clusters, const VoxelSet& held) {
    for (Cluster& cluster : clusters) {
      std::erase_if(cluster.viewpoints, [&](const Viewpoint& v) {
        const auto count =
            std::count_if(v.elements.begin(), v.elements.end(), [&](const VoxelIndex& e) { return held.contains(e); });
        return !v.elements.empty() && static_cast<double>(count) > kHeldShare * static_cast<double>(v.elements.size());
      });
    }
    std::erase_if(clusters, [](const Cluster& c) { return c.viewpoints.empty(); });
  }

  /// Nothing is left, everybody stands, and all that was seen is here.
  void note_whether_done(const std::vector<Member*>& running, bool empty, Time now) {
    const bool all_idle =
        std::all_of(running.begin(), running.end(), [](const Member* m) { return m->state.idle && m->patches > 0; });
    const bool over = empty && all_idle && visits.empty() && first_running && now - *first_running > kLeastMission;
    nothing_left = over ? nothing_left + 1 : 0;
    status.done = status.done || nothing_left >= kSureTimes;
  }

  void send(Member& member, const std::optional<Viewpoint>& committed, const std::vector<Viewpoint>& given, Time now) {
    TeamTour tour;
    tour.stamp = now;
    tour.number = ++number;
    tour.robot = member.state.robot;
    tour.state_stamp = member.state.stamp;
    tour.valid_s = params.valid_s;
    tour.samples_below = ledger.all_below(tour.robot);
    tour.done = status.done;
    if (committed) tour.viewpoints.push_back(*committed);
    for (const Viewpoint& viewpoint : given) {
      if (static_cast<int>(tour.viewpoints.size()) < params.most_viewpoints) tour.viewpoints.push_back(viewpoint);
    }
    remember(tour, member);
    due.emplace_back(now + from_seconds(params.plan_latency_s), std::move(tour));
  }

  void remember(const TeamTour& tour, Member& member) {
    for (const Viewpoint& viewpoint : tour.viewpoints) {
      std::erase_if(remembered, [&](const Viewpoint& v) { return same_goal(v.pose, viewpoint.pose); });
      remembered.push_back(viewpoint);
    }
    while (remembered.size() > kRemembered) remembered.pop_front();
    member.sent = tour.number;
    member.sent_viewpoints = tour.viewpoints.size();
  }

  void recall(const TeamTour& tour) {
    number = std::max(number, tour.number);
    status.done = status.done || tour.done;
    remember(tour, members[tour.robot]);
  }

  std::vector<TeamTour> take_due(Time now) {
    std::vector<TeamTour> ready;
    std::erase_if(due, [&](auto& entry) {
      if (entry.first > now) return false;
      ready.push_back(std::move(entry.second));
      return true;
    });
    return ready;
  }
};

Centre::Centre(const CentreParams& params, const LevelCamera& camera) {
  config::check(params, "centre");
  state_ = std::make_unique<State>(params, camera);
}
Centre::~Centre() = default;

Result<std::size_t> Centre::take(const mapping::MapPatch& patch) {
  return state_->take(patch);
}
void Centre::take(const RobotState& state, Time now) {
  state_->take(state, now);
}
void Centre::take(const TourReport& report, Time now) {
  state_->take(report, now);
}
void Centre::recall(const TeamTour& tour) {
  state_->recall(tour);
}
std::vector<TeamTour> Centre::step(Time now) {
  return state_->step(now);
}
const mapping::TsdfMap& Centre::map() const {
  return state_->map;
}
const CentreStatus& Centre::status() const {
  return state_->status;
}

}  // namespace arpent::planning
