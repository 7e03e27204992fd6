// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/team_live.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <set>

#include "common/cpu_time.h"
#include "common/error.h"
#include "common/net/radio_network.h"
#include "common/net/tap_hub.h"
#include "common/split.h"
#include "sim/world/world.h"
#include "tools/mission/encounters.h"
#include "tools/mission/live.h"
#include "tools/mission/live_bus.h"
#include "tools/mission/team_live_result.h"
#include "tools/progress.h"
#include "tools/team/keys.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using Steady = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// Some seconds as a rule; with much loss now and then half a minute.
constexpr auto kMeet = 60s;
constexpr char kLink[] = "team_link_process";

/// A folder for keys and sockets, gone with this.
class Scratch {
 public:
  Scratch() {
    std::string name = (fs::temp_directory_path() / "arpent_team_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw InputError("cannot make a folder " + name);
    folder_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

AirParams air_of(const sim::RadioParams& radio) {
  return {.loss = radio.loss, .delay_s = radio.delay_s, .rate_mbps = radio.rate_mbps};
}

/// The processes of all stations, from their start to their end.
class LiveTeam {
 public:
  LiveTeam(const MissionSpec& spec, const MissionOptions& options)
      : spec_(spec),
        options_(options),
        names_(robot_names(spec)),
        air_(air_of(spec.radio.radio), static_cast<std::uint64_t>(spec.seed)),
        log_(options.out / "launch.log"),
        launcher_(log_) {
    std::vector<std::string> stations = names_;
    stations.emplace_back(kCentre);
    make_keys({.out = scratch_.folder() / "keys", .stations = stations});
    for (const std::string& station : stations) open(station);
    start_all();
  }

  /// Waits until every process speaks and all links hear each other; false if interrupted.
  bool come_up() {
    wait_until(
        kComeUp * static_cast<int>(names_.size()), [this] { return silent(); }, "{} does not come up");
    wait_until(
        kMeet, [this] { return unheard(); }, "the radio link does not come up: {}");
    return !interrupted();
  }

  /// Starts the missions and sees them to their ends.
  void drive() {
    const auto start = Steady::now();
    const double limit_s = spec_.mission.max_time_s + kPatienceS;
    while (!all_ended() && !interrupted()) {
      const double elapsed_s = std::chrono::duration<double>(Steady::now() - start).count();
      if (elapsed_s > limit_s) throw InputError("the mission does not end; see " + log_.string());
      kill_due(elapsed_s);
      for (std::size_t i = 0; i < names_.size(); ++i) {
        if (!is_dead(names_[i])) bus(i).ear().start_mission();
      }
      listen(200ms);
      if (options_.progress) show();
    }
  }

  /// In the reverse order of their start: the missions first, then the centre, the simulators last; then the loggers,
  /// which have heard all of them.
  void end() {
    for (int i = 0; i < 5; ++i) listen_only(200ms);
    launcher_.restart_no_more();
    for (auto name = started_.rbegin(); name != started_.rend(); ++name) {
      launcher_.stop(*name, 20000);
      listen_only(1ms);
    }
    listen_only(300ms);
    air_bytes_ = air_.traffic().bytes;
    launcher_.stop_all(5000);
  }

  [[nodiscard]] TeamResult result() {
    TeamResult result;
    result.names = names_;
    result.died = died_;
    for (std::size_t i = 0; i <= names_.size(); ++i) result.processes.merge(bus(i).figures());
    for (std::size_t i = 0; i < names_.size(); ++i) {
      result.robots.push_back(result_of_robot(bus(i).raw_log(), robot_spec(i)));
      const auto& counters = result.processes[names_[i] + "/" + SimProcess::kName].counters;
      const auto contacts = counters.find("WORLD.collision");
      result.robots.back().collisions = contacts == counters.end() ? 0 : static_cast<int>(contacts->second);
    }
    result.centre = status_of_centre(bus(names_.size()).raw_log());
    result.centre.lost = static_cast<int>(died_.size());
    result.mesh = take_mesh(map_file());
    result.radio_bytes = radio_bytes(result.processes, air_bytes_);
    return result;
  }

 private:
  [[nodiscard]] LiveBus& bus(std::size_t station) { return *buses_[station]; }
  [[nodiscard]] fs::path map_file() const { return fs::absolute(options_.out / kCentre / "live.map"); }

  /// The station's network, its place at the radio, its bus.
  void open(const std::string& station) {
    const std::string address = fmt::format("10.77.0.{}", networks_.size() + 1);
    RadioNetwork& network = *networks_.emplace_back(std::make_unique<RadioNetwork>(address));
    air_.attach(network.release_tap());
    const LiveBusPlace place{station + "/", options_.out / station, kDefaultLcmUrl, network.network_fd()};
    buses_.push_back(std::make_unique<LiveBus>(place, launcher_, options_.bin_folder));
  }

  [[nodiscard]] MissionSpec robot_spec(std::size_t i) const {
    MissionSpec robot = spec_of_robot(spec_, static_cast<int>(i));
    robot.sim.name = names_[i];
    robot.sim.truth_folder = scratch_.folder();
    return robot;
  }

  void start(std::size_t station, const Member& member, bool restart) {
    bus(station).start(member, restart);
    started_.push_back(bus(station).names().back());
  }

  [[nodiscard]] Member link_of(const std::string& station, const char* role) const {
    const fs::path keys = scratch_.folder() / "keys" / station;
    return {kLink, fmt::format("station: {}\nrole: {}\nlink:\n  interface: radio0\n  keys: {}\n", station, role,
                               keys.string())};
  }

  void start_all() {
    // A world that starts anew would put the robot back: its end is the run's.
    for (std::size_t i = 0; i < names_.size(); ++i) start(i, robot_members(robot_spec(i)).front(), false);
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const MissionSpec robot = robot_spec(i);
      const std::vector<Member> members = robot_members(robot);
      for (std::size_t m = 1; m < members.size(); ++m) start(i, members[m], true);
      start(i, {PatchProcess::kName, config::to_yaml(robot.patch)}, true);
      start(i, link_of(names_[i], "robot"), true);
    }
    CentreConfig centre = spec_.centre;
    centre.map_file = map_file();
    std::error_code ignored;
    fs::remove(centre.map_file, ignored);
    centre.journal_file = fs::absolute(options_.out / kCentre / "journal.lcmlog");
    fs::remove(centre.journal_file, ignored);
    start(names_.size(), link_of(kCentre, "centre"), true);
    start(names_.size(), {CentreProcess::kName, config::to_yaml(centre)}, true);
    for (std::size_t i = 0; i < names_.size(); ++i) {
      start(i, {MissionProcess::kName, config::to_yaml(robot_spec(i).mission)}, true);
    }
  }

  void listen_only(std::chrono::milliseconds time) {
    const auto each = std::max<std::chrono::milliseconds>(1ms, time / static_cast<int>(buses_.size()));
    for (const auto& bus : buses_) bus->ear().listen(each);
  }
  void listen(std::chrono::milliseconds time) {
    watch(launcher_, log_);
    listen_only(time);
  }

  /// Until `missing` names nothing any more; its name goes into `complaint` when the time is up.
  template <class Missing>
  void wait_until(std::chrono::seconds time, Missing missing, const char* complaint) {
    const auto limit = Steady::now() + time;
    for (std::string what = missing(); !what.empty() && !interrupted(); what = missing()) {
      if (Steady::now() > limit) {
        throw InputError(fmt::format(fmt::runtime(complaint), what) + "; see " + log_.string());
      }
      listen(100ms);
    }
  }

  [[nodiscard]] std::string silent() const {
    for (const auto& bus : buses_) {
      if (std::string name = bus->silent(); !name.empty()) return name;
    }
    return "";
  }

  /// The first link that has not heard another.
  [[nodiscard]] std::string unheard() const {
    for (std::size_t i = 0; i < buses_.size(); ++i) {
      const auto figures = buses_[i]->ear().figures().find(kLink);
      for (std::size_t k = 0; k < buses_.size(); ++k) {
        if (i == k || figures->second.counters.count(station_name(k) + ".heard") > 0) continue;
        return station_name(i) + " does not hear " + station_name(k);
      }
    }
    return "";
  }
  [[nodiscard]] std::string station_name(std::size_t station) const {
    return station < names_.size() ? names_[station] : kCentre;
  }

  [[nodiscard]] bool is_dead(const std::string& name) const {
    return std::find(died_.begin(), died_.end(), name) != died_.end();
  }
  [[nodiscard]] bool all_ended() {
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (!is_dead(names_[i]) && !bus(i).ear().ended()) return false;
    }
    return true;
  }

  /// All but the simulator: its body stays where it is.
  void kill_due(double elapsed_s) {
    for (const TeamEvent& death : deaths(spec_)) {
      if (is_dead(death.who) || elapsed_s < death.at_s) continue;
      const auto robot = std::find(names_.begin(), names_.end(), death.who) - names_.begin();
      for (const std::string& name : bus(static_cast<std::size_t>(robot)).names()) {
        if (name != death.who + "/" + SimProcess::kName) launcher_.kill(name);
      }
      died_.push_back(death.who);
    }
  }

  void show() {
    std::string activity;
    double progress = 0;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const auto& report = bus(i).ear().report();
      if (!report) continue;
      activity += (activity.empty() ? "" : " | ") + report->activity.substr(0, 24);
      progress = std::max(progress, report->progress);
    }
    show_progress(activity, static_cast<std::size_t>(progress * kProgressSteps), kProgressSteps);
  }

  const MissionSpec& spec_;
  const MissionOptions& options_;
  std::vector<std::string> names_, died_, started_;
  Scratch scratch_;
  TapHub air_;
  std::vector<std::unique_ptr<RadioNetwork>> networks_;
  fs::path log_;
  Launcher launcher_;
  std::vector<std::unique_ptr<LiveBus>> buses_;
  std::int64_t air_bytes_ = 0;
};

}  // namespace

TeamResult run_live_team(const MissionSpec& spec, const MissionOptions& options) {
  const auto wall_start = Steady::now();
  const double cpu_start = process_cpu_s() + children_cpu_s();
  const std::vector<TeamEvent> dying = deaths(spec);
  if (!joins(spec).empty() || std::any_of(dying.begin(), dying.end(), [](const auto& d) { return d.who == kCentre; })) {
    throw InputError("joining late, and a centre that dies, are for lockstep: leave out --live");
  }
  for (int i = 0; i < spec.robots; ++i) (void)sim::start_of(sim::load_world(spec.world), spec.start + i);
  if (const std::string reason = radio_network_refused(); !reason.empty()) {
    throw InputError("a live team needs network namespaces, which this machine refuses: " + reason);
  }
  (void)interrupted();  // from here on Ctrl-C is an orderly end
  fs::create_directories(options.out);
  TeamResult result;
  {
    LiveTeam team(spec, options);
    if (team.come_up()) team.drive();
    team.end();
    result = team.result();
  }
  std::vector<evaluation::Trajectory> truths;
  for (const MissionResult& robot : result.robots) truths.push_back(robot.truth);
  result.encounters = encounters_of(config::load<RobotConfig>(spec.robot), truths);
  warn_if_late(result);
  result.cpu_s = process_cpu_s() + children_cpu_s() - cpu_start;
  result.wall_s = std::chrono::duration<double>(Steady::now() - wall_start).count();
  return result;
}

}  // namespace arpent::tools
