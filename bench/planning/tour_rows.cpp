// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/planning/tour_rows.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "bench/planning/tour_instances.h"
#include "common/error.h"
#include "planning/tour/held_karp.h"
#include "planning/tour/max_atsp.h"
#include "planning/tour/team.h"
#include "planning/tour/timed_tours.h"

namespace arpent::bench {
namespace {

constexpr double kLambdaTc1pm = 0.5, kLambdaIc1pm = 0.01;  // thesis, test arena
constexpr double kSpeedMps = 0.5;

std::map<std::tuple<int, std::string, unsigned>, double> read_truth() {
  std::map<std::tuple<int, std::string, unsigned>, double> best;
  std::ifstream in(ARPENT_TOUR_TRUTH);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::vector<std::string> cells;
    for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
      end = line.find(',', begin);
      cells.push_back(line.substr(begin, end - begin));
    }
    best[{std::stoi(cells.at(0)), cells.at(1), static_cast<unsigned>(std::stoul(cells.at(2)))}] =
        std::stod(cells.at(3));
  }
  if (best.empty()) throw InputError(std::string(ARPENT_TOUR_TRUTH) + ": cannot be read");
  return best;
}

std::string short_text(double value) {
  return std::to_string(value).substr(0, 3);
}

/// Share of the best known utility that the solver misses, with local search for all sizes.
void gap_rows(Report& report) {
  const auto best = read_truth();
  double sum = 0, most = 0, bound_sum = 0, greedy_sum = 0, ms = 0;
  for (const TourCase& c : tour_cases()) {
    const tour::Arcs utility = random_clusters(c.clusters, 1, c.seed).utilities(c.lambda_tc_1pm, kLambdaIc1pm);
    const std::vector<double> from_start = from_only_start(utility);
    tour::SolverParams params;
    params.exact_up_to = 0;
    tour::OpenTour tour;
    ms += cpu_ms([&] { tour = tour::max_atsp(from_start, utility.among, params); });
    const double truth = best.at({c.clusters, short_text(c.lambda_tc_1pm), c.seed});
    const double gap = 100 * (truth - tour.value) / truth;
    sum += gap;
    most = std::max(most, gap);
    bound_sum += 100 * (tour.bound - tour.value) / tour.value;
    greedy_sum += 100 * (truth - tour::nearest_neighbour_tour(from_start, utility.among).value) / truth;
  }
  const auto count = static_cast<double>(tour_cases().size());
  report.add("atsp.gap_percent_mean", sum / count, "%", "bar <= 0.1; 12 to 60 clusters, of the best known utility");
  report.add("atsp.gap_percent_max", most, "%", "bar <= 0.5");
  report.add("atsp.reported_gap_percent_mean", bound_sum / count, "%", "between the tour and the reported bound");
  report.add("atsp.greedy_gap_percent_mean", greedy_sum / count, "%", "of nearest neighbours");
  report.add("atsp.ms_mean", ms / count, "ms", "a solve with the default budget of steps and the bound");
}

void time_rows(Report& report) {
  const tour::Arcs twelve = random_clusters(12, 1, 1).utilities(kLambdaTc1pm, kLambdaIc1pm);
  report.add_time(
      "atsp.exact12_ms", [&] { (void)tour::max_atsp(from_only_start(twelve), twelve.among, {}); }, 7, "bar <= 0.05");
  const tour::ClusterGraph graph = random_clusters(40, 4, 1);
  const tour::Arcs utility = graph.utilities(kLambdaTc1pm, kLambdaIc1pm), legs_s = graph.durations_s(kSpeedMps);
  report.add_time(
      "tsga.ms_40x4", [&] { (void)tour::tsga(utility, legs_s.from_start, {}); }, 7, "bar <= 0.85");
  report.add_time(
      "timed.ms_40x4", [&] { (void)tour::timed_tours(legs_s, graph.gains(), {}); }, 7, "reported");
}

/// Mean figures of one way to plan over seeded problems.
struct Outcome {
  double arrival_s = 0, completion_s = 0, path_m = 0;

  void add(const tour::Arcs& legs_s, const std::vector<double>& gain, const std::vector<std::vector<int>>& order,
           double share) {
    const tour::TimedTours tours = tour::evaluate_timed(legs_s, gain, {}, order);
    arrival_s += share * tours.mean_arrival_s;
    completion_s += share * tours.completion_s;
    for (std::size_t r = 0; r < order.size(); ++r) {
      for (std::size_t p = 0; p < order[r].size(); ++p) {
        path_m += share * kSpeedMps *
                  (p == 0 ? legs_s.from_start(static_cast<Eigen::Index>(r), order[r][p])
                          : legs_s.among(order[r][p - 1], order[r][p]));
      }
    }
  }
  void report(Report& report, const std::string& name, const std::string& note) const {
    report.add("tour.arrival_s_" + name, arrival_s, "s", note + ": gain-weighted mean arrival");
    report.add("tour.completion_s_" + name, completion_s, "s", note + ": the last robot's end");
    report.add("tour.path_m_" + name, path_m, "m", note + ": all robots");
  }
};

/// The same problems planned for different ends; what each is good for in seconds and metres.
void objective_rows(Report& report, int robots) {
  constexpr int kProblems = 12;
  const std::vector<std::pair<std::string, double>> weights = {
      {"latency", 0.0}, {"default", tour::TimedParams{}.completion_weight}, {"shortest", 1e3}};
  std::vector<Outcome> outcomes(weights.size());
  Outcome thesis, greedy;
  for (unsigned seed = 1; seed <= kProblems; ++seed) {
    const tour::ClusterGraph graph = random_clusters(15 + 2 * static_cast<int>(seed), robots, seed);
    const tour::Arcs legs_s = graph.durations_s(kSpeedMps);
    const tour::Arcs utility = graph.utilities(kLambdaTc1pm, kLambdaIc1pm);
    std::vector<std::vector<int>> order;
    for (const tour::OpenTour& tour : tour::tsga(utility, legs_s.from_start, {})) order.push_back(tour.order);
    thesis.add(legs_s, graph.gains(), order, 1.0 / kProblems);
    for (std::size_t w = 0; w < weights.size(); ++w) {
      tour::TimedParams params;
      params.completion_weight = weights[w].second;
      const tour::TimedTours tours = tour::timed_tours(legs_s, graph.gains(), params);
      outcomes[w].add(legs_s, graph.gains(), tours.order, 1.0 / kProblems);
    }
    if (robots > 1) continue;
    greedy.add(legs_s, graph.gains(), {tour::nearest_neighbour_tour(from_only_start(utility), utility.among).order},
               1.0 / kProblems);
  }
  const std::string suffix = robots > 1 ? "_" + std::to_string(robots) + "robots" : "";
  if (robots == 1) greedy.report(report, "nearest" + suffix, "greatest utility next");
  thesis.report(report, "thesis" + suffix, robots > 1 ? "TSGA" : "maxATSP");
  for (std::size_t w = 0; w < weights.size(); ++w) {
    outcomes[w].report(report, weights[w].first + suffix, "completion weight " + short_text(weights[w].second));
  }
}

}  // namespace

void tour_rows(Report& report) {
  gap_rows(report);
  time_rows(report);
  objective_rows(report, 1);
  objective_rows(report, 3);
}

}  // namespace arpent::bench
