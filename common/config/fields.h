// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How a struct of parameters describes itself. Each `Params` and process `Config` has one static member template that
// names every field once, with its help (unit in the key's suffix) and its rules; the default stays in the struct.
// Loading, printing, checking and the generated reference documentation are all visitors of it (config.h).
//
//   struct TsdfParams {
//     double voxel_m = 0.1;
//     std::string carving = "on";
//     template <class Self, class Visitor>
//     static void describe(Self& self, Visitor& visitor) {
//       visitor.field("voxel_m", self.voxel_m, "edge of a voxel", config::greater_than(0.0));
//       visitor.field("carving", self.carving, "clear free space in front of surfaces", config::one_of({"on", "off"}));
//     }
//   };
//
// A nested struct is `visitor.group("tsdf", self.tsdf, "the map")`. Field types: bool, int, double, std::string,
// std::vector<double>, std::filesystem::path.
#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace arpent::config {

/// A rule on a value: `text` completes the sentence "must be …".
template <class T>
struct Rule {
  std::string text;
  std::function<bool(const T&)> holds;
};

namespace detail {
std::string to_text(double value);
std::string to_text(const std::vector<std::string>& values);
}  // namespace detail

template <class T>
[[nodiscard]] Rule<T> greater_than(T bound) {
  return {"> " + detail::to_text(static_cast<double>(bound)), [bound](const T& v) { return v > bound; }};
}
template <class T>
[[nodiscard]] Rule<T> at_least(T bound) {
  return {">= " + detail::to_text(static_cast<double>(bound)), [bound](const T& v) { return v >= bound; }};
}
/// lowest <= v <= highest.
template <class T>
[[nodiscard]] Rule<T> between(T lowest, T highest) {
  return {"between " + detail::to_text(static_cast<double>(lowest)) + " and " +
              detail::to_text(static_cast<double>(highest)),
          [lowest, highest](const T& v) { return v >= lowest && v <= highest; }};
}
[[nodiscard]] Rule<std::string> one_of(std::vector<std::string> choices);
/// A path that has no default.
[[nodiscard]] Rule<std::filesystem::path> required_path();
/// A text that has no default.
[[nodiscard]] Rule<std::string> required_text();
/// As many finite numbers as said.
[[nodiscard]] Rule<std::vector<double>> finite_numbers(std::size_t count);

}  // namespace arpent::config
