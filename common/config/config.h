// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Configuration: a YAML file, plus `key=value` settings from flags, into a struct that describes itself (fields.h).
// Every fault is found and reported at once, each as `file:line: key = value, must be …`; nothing is clamped, repaired
// or ignored. Paths are relative to the file that they stand in.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "common/config/fields.h"

namespace arpent::config {

/// One field of a config struct: where its value is, and what is asked of it.
struct FieldRef {
  using Value = std::variant<bool*, int*, double*, std::string*, std::vector<double>*, std::filesystem::path*>;
  std::string key;  ///< dotted, e.g. "tsdf.voxel_m"
  Value value;
  std::string help;
  std::vector<std::pair<std::string, std::function<bool()>>> rules;
};

/// The visitor that lists a struct's fields.
class FieldCollector {
 public:
  template <class T, class... Rules>
  void field(const std::string& key, T& value, const std::string& help, Rules... rules) {
    FieldRef ref{prefix_ + key, &value, help, {}};
    (ref.rules.emplace_back(rules.text, [rule = rules, &value] { return rule.holds(value); }), ...);
    fields_.push_back(std::move(ref));
  }

  template <class Group>
  void group(const std::string& key, Group& group, const std::string& /*help*/) {
    const std::string outer = prefix_;
    prefix_ += key + '.';
    Group::describe(group, *this);
    prefix_ = outer;
  }

  [[nodiscard]] std::vector<FieldRef> take() { return std::move(fields_); }

 private:
  std::string prefix_;
  std::vector<FieldRef> fields_;
};

template <class C>
[[nodiscard]] std::vector<FieldRef> fields_of(C& config) {
  FieldCollector collector;
  C::describe(config, collector);
  return collector.take();
}

/// Where values come from.
struct Sources {
  std::filesystem::path file = {};         ///< empty: none
  std::string text = {};                   ///< YAML text instead of a file
  std::string text_name = "config";        ///< what faults in `text` are reported under
  std::vector<std::string> settings = {};  ///< "key=value", after the file
};

/// Key -> "default", "file:line" or "flag".
using Origins = std::map<std::string, std::string>;

namespace detail {
/// Fills the fields. Throws InputError that lists every fault, a line each.
Origins read(const std::vector<FieldRef>& fields, const Sources& sources);
[[nodiscard]] std::string print(const std::vector<FieldRef>& fields, const Origins& origins);
[[nodiscard]] std::string reference(const std::vector<FieldRef>& fields);
/// Throws InputError that lists the broken rules.
void check(const std::vector<FieldRef>& fields, const std::string& what);
}  // namespace detail

/// Reads `config` (its values before are the defaults). Throws InputError that lists every fault.
template <class C>
Origins read(C& config, const Sources& sources) {
  return detail::read(fields_of(config), sources);
}

template <class C>
[[nodiscard]] C load(const std::filesystem::path& file) {
  C config;
  read(config, {.file = file});
  return config;
}

template <class C>
[[nodiscard]] C load_text(const std::string& name, const std::string& text) {
  C config;
  read(config, {.text = text, .text_name = name});
  return config;
}

/// Every effective value as YAML, each with its help and origin as a comment; it loads back to the same values.
template <class C>
[[nodiscard]] std::string to_yaml(C config, const Origins& origins = {}) {
  return detail::print(fields_of(config), origins);
}

/// A Markdown table of all keys: default, rule, meaning.
template <class C>
[[nodiscard]] std::string reference_markdown() {
  C config;
  return detail::reference(fields_of(config));
}

/// Throws InputError if a rule of the struct's does not hold: for values that did not come through read().
template <class C>
void check(const C& config, const std::string& what) {
  C copy = config;
  detail::check(fields_of(copy), what);
}

}  // namespace arpent::config
