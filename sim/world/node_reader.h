// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Reads nested YAML with lists of maps, which flat config structs cannot describe, with the manners of common/config:
// every fault is collected as `file:line: …`, unknown keys are faults, nothing is repaired.
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <set>
#include <string>
#include <vector>

namespace arpent::sim {

/// The faults of one file.
class Faults {
 public:
  explicit Faults(std::string name) : name_(std::move(name)) {}
  /// `line`: from 1; 0 names the file alone.
  void add(int line, const std::string& text);
  [[nodiscard]] bool empty() const { return lines_.empty(); }
  /// Throws InputError that lists them, if there are any.
  void throw_if_any() const;

 private:
  std::string name_;
  std::vector<std::string> lines_;
};

/// Whether a number must be positive, not negative, or may be anything.
enum class Sign : std::int8_t { kAny, kNotNegative, kPositive };

/// One map of the file. Values that are absent keep what they were, unless `required`; `finish` complains about keys
/// that nobody asked for.
class NodeReader {
 public:
  NodeReader(YAML::Node node, std::string what, Faults& faults);

  [[nodiscard]] bool has(const std::string& key) const;
  [[nodiscard]] int line() const { return line_; }
  /// The child, marked as asked for; undefined if absent.
  YAML::Node child(const std::string& key, bool required = false);

  bool number(const std::string& key, double& value, Sign sign = Sign::kAny, bool required = false);
  bool whole(const std::string& key, int& value, bool required = false);
  bool text(const std::string& key, std::string& value, bool required = false);
  bool numbers(const std::string& key, std::vector<double>& values, std::size_t count, bool required = false);
  bool vector(const std::string& key, Eigen::Vector3d& value, bool required = false);

  void fault(const std::string& text) { faults_.add(line_, what_ + ": " + text); }
  void finish();

 private:
  void fault_at(const YAML::Node& node, const std::string& text);

  YAML::Node node_;
  std::string what_;
  Faults& faults_;
  int line_;
  std::set<std::string> asked_;
};

}  // namespace arpent::sim
