// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What every benchmark shares: the table, the flat JSON list, CPU timing, and the reference that makes machines
// comparable. Times are thread CPU times, the median of several runs; `ref.sgbm_ms` (one padded StereoSGBM,
// MODE_SGBM_3WAY, 640x512, 128 disparities, one thread) is timed in the same run, between the subject's own
// repetitions, so that a ratio can be taken on any machine.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace arpent::bench {

struct Row {
  std::string name;  ///< e.g. "elas.ms_640x512_d128"
  double value;      ///< yes is 1, no is 0
  std::string unit;  ///< e.g. "ms", "%", "1"
  std::string note;  ///< bar or remark, for the table only
};

class Report {
 public:
  /// Adds a figure and prints its line at once, so that a long benchmark shows progress.
  void add(const std::string& name, double value, const std::string& unit, const std::string& note = "");
  /// Adds `name` [ms] and `name`_over_ref (the ratio to ref.sgbm_ms, timed now, interleaved with `work`). Returns the
  /// ratio.
  double add_time(const std::string& name, const std::function<void()>& work, int repetitions = 7,
                  const std::string& note = "");
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }

 private:
  std::vector<Row> rows_;
};

/// CPU time of the calling process (all its threads) spent in `work` [ms].
[[nodiscard]] double cpu_ms(const std::function<void()>& work);
/// Median of an odd or even number of values.
[[nodiscard]] double median(std::vector<double> values);
/// One run of the reference matcher; returns its CPU time [ms].
[[nodiscard]] double time_reference_once();

/// Folder of the public test data (ARPENT_DATA), or empty if it is not set or not there.
[[nodiscard]] std::string data_dir();

/// The `main` of a benchmark: --json FILE, --help; runs `body`, adds ref.sgbm_ms, writes the JSON. Returns the exit
/// code.
int run(int argc, char** argv, const std::string& title, const std::function<void(Report&)>& body);

}  // namespace arpent::bench
