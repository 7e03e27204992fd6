// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/node_reader.h"

#include <fmt/format.h>

#include <cmath>

#include "common/error.h"

namespace arpent::sim {

void Faults::add(int line, const std::string& text) {
  lines_.push_back(line > 0 ? fmt::format("{}:{}: {}", name_, line, text) : fmt::format("{}: {}", name_, text));
}

void Faults::throw_if_any() const {
  if (!lines_.empty()) throw InputError(fmt::format("{}", fmt::join(lines_, "\n")));
}

NodeReader::NodeReader(YAML::Node node, std::string what, Faults& faults)
    : node_(std::move(node)), what_(std::move(what)), faults_(faults), line_(node_.Mark().line + 1) {
  if (!node_.IsMap()) {
    fault("must be a group of keys");
    node_ = YAML::Node(YAML::NodeType::Map);
  }
}

bool NodeReader::has(const std::string& key) const {
  const YAML::Node& node = node_;
  return node[key].IsDefined();
}

YAML::Node NodeReader::child(const std::string& key, bool required) {
  asked_.insert(key);
  const YAML::Node& node = node_;
  if (!node[key].IsDefined()) {
    if (required) fault("missing key " + key);
    return YAML::Node(YAML::NodeType::Undefined);
  }
  return node[key];
}

void NodeReader::fault_at(const YAML::Node& node, const std::string& text) {
  faults_.add(node.Mark().line + 1, what_ + ": " + text);
}

bool NodeReader::number(const std::string& key, double& value, Sign sign, bool required) {
  const YAML::Node node = child(key, required);
  if (!node.IsDefined()) return false;
  double read = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, read) || !std::isfinite(read)) {
    fault_at(node, key + " must be a finite number");
    return false;
  }
  if ((sign == Sign::kPositive && read <= 0) || (sign == Sign::kNotNegative && read < 0)) {
    fault_at(node, fmt::format("{} = {}, must be {}", key, read, sign == Sign::kPositive ? "> 0" : ">= 0"));
    return false;
  }
  value = read;
  return true;
}

bool NodeReader::whole(const std::string& key, int& value, bool required) {
  const YAML::Node node = child(key, required);
  if (!node.IsDefined()) return false;
  if (node.IsScalar() && YAML::convert<int>::decode(node, value)) return true;
  fault_at(node, key + " must be a whole number");
  return false;
}

bool NodeReader::text(const std::string& key, std::string& value, bool required) {
  const YAML::Node node = child(key, required);
  if (!node.IsDefined()) return false;
  if (!node.IsScalar()) {
    fault_at(node, key + " must be a text");
    return false;
  }
  value = node.Scalar();
  return true;
}

bool NodeReader::numbers(const std::string& key, std::vector<double>& values, std::size_t count, bool required) {
  const YAML::Node node = child(key, required);
  if (!node.IsDefined()) return false;
  std::vector<double> read;
  bool sound = node.IsSequence() && node.size() == count;
  for (std::size_t i = 0; sound && i < count; ++i) {
    double x = 0;
    sound = node[i].IsScalar() && YAML::convert<double>::decode(node[i], x) && std::isfinite(x);
    read.push_back(x);
  }
  if (!sound) {
    fault_at(node, fmt::format("{} must be a list of {} finite numbers", key, count));
    return false;
  }
  values = read;
  return true;
}

bool NodeReader::vector(const std::string& key, Eigen::Vector3d& value, bool required) {
  std::vector<double> values;
  if (!numbers(key, values, 3, required)) return false;
  value = Eigen::Vector3d(values[0], values[1], values[2]);
  return true;
}

void NodeReader::finish() {
  for (const auto& item : node_) {
    const std::string key = item.first.IsScalar() ? item.first.Scalar() : "?";
    if (asked_.insert(key).second) fault_at(item.first, "unknown key " + key);
  }
}

}  // namespace arpent::sim
