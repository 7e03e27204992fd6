// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent tour FILE.atsp`: the cheapest closed tour of a TSPLIB file with the planner's solver. The search counts
// steps; a time only chooses how many, by the speed measured on the way.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/atomic_file.h"
#include "common/cpu_time.h"
#include "common/error.h"
#include "planning/tour/max_atsp.h"
#include "tools/tour/tsplib.h"

namespace {

using namespace arpent;
struct Flags {
  std::string file, json;
  double time_ms = 200;
  double steps = 0;
};

/// CPU time of this process: another's load on the machine must not cost steps.
double now_ms() {
  return 1e3 * process_cpu_s();
}

/// Total steps so that the search ends at `until_ms`: a first piece measures the speed, later ones correct it.
class Deadline {
 public:
  explicit Deadline(double until_ms) : until_ms_(until_ms) {}

  double operator()(double steps_taken) {
    constexpr double kFirstPiece = 50000;
    if (steps_taken == 0) {
      begin_ms_ = now_ms();
      return kFirstPiece;
    }
    steps_per_ms = steps_taken / std::max(now_ms() - begin_ms_, 1e-3);
    return steps_taken + 0.5 * steps_per_ms * (until_ms_ - now_ms()) - kFirstPiece / 20;
  }

  double steps_per_ms = 0;

 private:
  double until_ms_;
  double begin_ms_ = 0;
};

int run(const Flags& flags) {
  const tour::TsplibProblem problem = tour::read_tsplib(flags.file);
  tour::SolverParams params;
  // The last part of the time is the bound's: its iterations are O(n^2), about 3 ns per pair of nodes.
  const double pairs = static_cast<double>(problem.cost.size());
  const double iteration_ms = 3e-6 * pairs;
  params.bound_iterations = static_cast<int>(std::clamp(0.25 * flags.time_ms / iteration_ms, 100.0, 1000.0));
  const double search_ms = flags.time_ms - iteration_ms * params.bound_iterations;
  const double start_ms = now_ms();
  Deadline deadline(start_ms + search_ms);
  params.steps = flags.steps;
  tour::ClosedTour best =
      flags.steps > 0 ? tour::min_atsp(problem.cost, params) : tour::min_atsp(problem.cost, params, std::ref(deadline));
  const double took_ms = now_ms() - start_ms;
  // Whole costs: so is the best tour's.
  if (problem.whole_numbers) best.bound = std::min(std::ceil(best.bound - 1e-6), best.cost);
  const double gap_percent = best.cost != 0 ? 100 * (best.cost - best.bound) / std::abs(best.cost) : 0;
  std::printf("%s: %td nodes, cost %.10g, no tour costs less than %.10g (gap %.2f %%)\n", problem.name.c_str(),
              problem.cost.rows(), best.cost, best.bound, gap_percent);
  if (best.steps == 0) {
    std::printf("exact, in %.1f ms\n", took_ms);
  } else {
    std::printf("%.0f steps in %.1f ms; the same again: --steps %.0f\n", best.steps, took_ms, best.steps);
    if (deadline.steps_per_ms > 0) std::printf("calibrated: %.0f steps per ms\n", deadline.steps_per_ms);
  }
  for (int& node : best.order) ++node;
  if (flags.json.empty()) {
    for (std::size_t i = 0; i < best.order.size(); ++i)
      std::printf("%d%c", best.order[i], (i + 1) % 20 == 0 ? '\n' : ' ');
    std::printf("\n");
    return 0;
  }
  const nlohmann::json out = {{"name", problem.name},
                              {"dimension", problem.cost.rows()},
                              {"cost", best.cost},
                              {"bound", best.bound},
                              {"gap_percent", gap_percent},
                              {"steps", best.steps},
                              {"steps_per_ms", deadline.steps_per_ms},
                              {"time_ms", took_ms},
                              {"tour", best.order}};
  atomic_write(flags.json, out.dump(1) + "\n");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"The cheapest closed tour of a TSPLIB file (TYPE ATSP, EDGE_WEIGHT_FORMAT FULL_MATRIX)."};
  app.name("arpent tour");
  Flags flags;
  app.add_option("FILE", flags.file, "TSPLIB file, *.atsp")->required();
  app.add_option("--time-ms", flags.time_ms, "CPU time to search in; it chooses the number of steps")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 3.6e6));
  app.add_option("--steps", flags.steps, "search this many steps instead: the same tour on every machine")
      ->check(CLI::Range(1.0, 1e12));
  app.add_option("--json", flags.json, "write cost, bound, gap_percent, tour (nodes from 1) and steps to this file");
  try {
    app.parse(argc, argv);
    return run(flags);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "tour: %s\n", error.what());
    return 2;
  }
}
