// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/config/config.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include "common/error.h"

namespace arpent::config {
namespace {

using Path = std::filesystem::path;

template <class... F>
struct Overload : F... {
  using F::operator()...;
};
template <class... F>
Overload(F...) -> Overload<F...>;

std::string quoted(const std::string& text) {
  YAML::Emitter emitter;
  emitter << YAML::DoubleQuoted << text;
  return emitter.c_str();
}

/// The shortest text that reads back as the same number, and always reads as a floating-point one.
std::string number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string value_text(const FieldRef::Value& value) {
  return std::visit(
      Overload{[](const bool* v) -> std::string { return *v ? "true" : "false"; },
               [](const int* v) { return std::to_string(*v); }, [](const double* v) { return number(*v); },
               [](const std::string* v) { return quoted(*v); }, [](const Path* v) { return quoted(v->string()); },
               [](const std::vector<double>* v) {
                 std::vector<std::string> parts;
                 for (const double x : *v) parts.push_back(number(x));
                 return fmt::format("[{}]", fmt::join(parts, ", "));
               }},
      value);
}

/// Reads a YAML scalar or sequence into the field. Returns what it should have been, or an empty string.
std::string assign(const FieldRef::Value& value, const YAML::Node& node, const Path& folder) {
  const auto scalar = [&](auto* target, const char* wanted) -> std::string {
    if (!node.IsScalar()) return wanted;
    return YAML::convert<std::remove_pointer_t<decltype(target)>>::decode(node, *target) ? "" : wanted;
  };
  return std::visit(
      Overload{[&](bool* v) { return scalar(v, "true or false"); }, [&](int* v) { return scalar(v, "a whole number"); },
               [&](double* v) {
                 const std::string fault = scalar(v, "a number");
                 return fault.empty() && !std::isfinite(*v) ? std::string("a finite number") : fault;
               },
               [&](std::string* v) { return scalar(v, "a text"); },
               [&](Path* v) -> std::string {
                 if (!node.IsScalar()) return "a path";
                 const Path path = node.Scalar();
                 *v = path.empty() || path.is_absolute() ? path : (folder / path).lexically_normal();
                 return "";
               },
               [&](std::vector<double>* v) -> std::string {
                 if (!node.IsSequence()) return "a list of numbers";
                 v->clear();
                 for (const auto& item : node) {
                   double x = 0;
                   if (!item.IsScalar() || !YAML::convert<double>::decode(item, x)) return "a list of numbers";
                   v->push_back(x);
                 }
                 return "";
               }},
      value);
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1] ? 1 : 0);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

std::string node_text(const YAML::Node& node) {
  if (node.IsScalar()) return node.Scalar();
  return node.IsSequence() ? "a list" : node.IsMap() ? "a group" : "nothing";
}

/// Reads one YAML document into the fields, collecting faults.
class Reader {
 public:
  Reader(const std::vector<FieldRef>& fields, std::string name, Path folder, Origins& origins,
         std::vector<std::string>& faults)
      : fields_(fields), name_(std::move(name)), folder_(std::move(folder)), origins_(origins), faults_(faults) {}

  void read(const std::string& text) {
    try {
      const YAML::Node root = YAML::Load(text);
      if (root.IsNull()) return;
      if (!root.IsMap()) {
        faults_.push_back(name_ + ": must be a list of `key: value` lines");
        return;
      }
      walk(root, "");
    } catch (const YAML::Exception& error) {
      faults_.push_back(fmt::format("{}:{}: not valid YAML: {}", name_, error.mark.line + 1, error.msg));
    }
  }

 private:
  void walk(const YAML::Node& map, const std::string& prefix) {
    std::set<std::string> seen;
    for (const auto& item : map) {
      if (!item.first.IsScalar()) {
        fault(item.first, "a key must be a text");
        continue;
      }
      const std::string key = prefix + item.first.Scalar();
      if (!seen.insert(key).second) {
        fault(item.first, key + " is given twice");
      } else {
        take(key, item.first, item.second);
      }
    }
  }

  void take(const std::string& key, const YAML::Node& at, const YAML::Node& node) {
    const auto field = std::find_if(fields_.begin(), fields_.end(), [&](const FieldRef& f) { return f.key == key; });
    if (field != fields_.end()) {
      const std::string wanted = assign(field->value, node, folder_);
      if (!wanted.empty()) fault(at, fmt::format("{} = {}, must be {}", key, node_text(node), wanted));
      origins_[key] = fmt::format("{}:{}", name_, at.Mark().line + 1);
      return;
    }
    const bool group =
        std::any_of(fields_.begin(), fields_.end(), [&](const FieldRef& f) { return f.key.starts_with(key + '.'); });
    if (!group) return unknown(key, at);
    if (node.IsMap()) return walk(node, key + '.');
    if (!node.IsNull()) fault(at, fmt::format("{} = {}, must be a group of keys", key, node_text(node)));
  }

  void unknown(const std::string& key, const YAML::Node& at) {
    const auto nearest = std::min_element(fields_.begin(), fields_.end(), [&](const auto& a, const auto& b) {
      return edit_distance(a.key, key) < edit_distance(b.key, key);
    });
    std::string text = "unknown key " + key;
    if (nearest != fields_.end() && edit_distance(nearest->key, key) <= key.size() / 2) {
      text += fmt::format(", did you mean {}?", nearest->key);
    }
    fault(at, text);
  }

  void fault(const YAML::Node& at, const std::string& text) {
    faults_.push_back(fmt::format("{}:{}: {}", name_, at.Mark().line + 1, text));
  }

  const std::vector<FieldRef>& fields_;
  std::string name_;
  Path folder_;
  Origins& origins_;
  std::vector<std::string>& faults_;
};

void read_setting(const std::vector<FieldRef>& fields, const std::string& setting, Origins& origins,
                  std::vector<std::string>& faults) {
  const auto equals = setting.find('=');
  if (equals == std::string::npos) {
    faults.push_back("--set " + setting + ": must be key=value");
    return;
  }
  std::string yaml = setting.substr(0, equals);
  std::string indent;
  for (auto dot = yaml.find('.'); dot != std::string::npos; dot = yaml.find('.', dot + 2)) {
    indent += ' ';
    yaml.replace(dot, 1, ":\n" + indent);
  }
  Origins mine;
  Reader(fields, "--set " + setting, "", mine, faults).read(yaml + ": " + setting.substr(equals + 1));
  for (const auto& [key, origin] : mine) origins[key] = "flag";
}

void check_rules(const std::vector<FieldRef>& fields, const Origins& origins, const std::string& name,
                 std::vector<std::string>& faults) {
  for (const FieldRef& field : fields) {
    for (const auto& [text, holds] : field.rules) {
      if (holds()) continue;
      const auto origin = origins.find(field.key);
      const std::string at = origin == origins.end() ? name : origin->second;
      faults.push_back(fmt::format("{}: {} = {}, must be {}", at, field.key, value_text(field.value), text));
    }
  }
}

void throw_if_any(const std::vector<std::string>& faults) {
  if (!faults.empty()) throw InputError(fmt::format("{}", fmt::join(faults, "\n")));
}

std::string read_file(const Path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  if (std::filesystem::is_directory(file) || !in || !(text << in.rdbuf())) {
    if (in && std::filesystem::is_regular_file(file) && std::filesystem::file_size(file) == 0) return "";
    throw InputError("cannot read the config file " + file.string());
  }
  return text.str();
}

}  // namespace

namespace detail {

std::string to_text(double value) {
  return fmt::format("{}", value);
}
std::string to_text(const std::vector<std::string>& values) {
  return fmt::format("{}", fmt::join(values, ", "));
}

Origins read(const std::vector<FieldRef>& fields, const Sources& sources) {
  Origins origins;
  std::vector<std::string> faults;
  if (!sources.file.empty()) {
    Reader(fields, sources.file.string(), sources.file.parent_path(), origins, faults).read(read_file(sources.file));
  }
  if (!sources.text.empty()) Reader(fields, sources.text_name, "", origins, faults).read(sources.text);
  for (const std::string& setting : sources.settings) read_setting(fields, setting, origins, faults);
  const std::string name = sources.file.empty() ? sources.text_name : sources.file.string();
  if (faults.empty()) check_rules(fields, origins, name, faults);
  throw_if_any(faults);
  return origins;
}

void check(const std::vector<FieldRef>& fields, const std::string& what) {
  std::vector<std::string> faults;
  check_rules(fields, {}, what, faults);
  throw_if_any(faults);
}

std::string print(const std::vector<FieldRef>& fields, const Origins& origins) {
  std::string text;
  std::vector<std::string> open;
  for (const FieldRef& field : fields) {
    std::vector<std::string> parts;
    std::stringstream stream(field.key);
    for (std::string part; std::getline(stream, part, '.');) parts.push_back(part);
    std::size_t level = 0;
    while (level < open.size() && level + 1 < parts.size() && open[level] == parts[level]) ++level;
    open.resize(level);
    for (; level + 1 < parts.size(); ++level) {
      text += fmt::format("{:{}}{}:\n", "", 2 * level, parts[level]);
      open.push_back(parts[level]);
    }
    const auto origin = origins.find(field.key);
    text += fmt::format("{:{}}{}: {}  # {}; {}\n", "", 2 * level, parts.back(), value_text(field.value), field.help,
                        origin == origins.end() ? "default" : origin->second);
  }
  return text;
}

std::string reference(const std::vector<FieldRef>& fields) {
  std::string text = "| key | default | must be | meaning |\n|---|---|---|---|\n";
  for (const FieldRef& field : fields) {
    std::vector<std::string> rules;
    for (const auto& rule : field.rules) rules.push_back(rule.first);
    text += fmt::format("| `{}` | `{}` | {} | {} |\n", field.key, value_text(field.value), fmt::join(rules, "; "),
                        field.help);
  }
  return text;
}

}  // namespace detail

Rule<std::string> one_of(std::vector<std::string> choices) {
  return {"one of " + detail::to_text(choices), [choices](const std::string& value) {
            return std::find(choices.begin(), choices.end(), value) != choices.end();
          }};
}

Rule<Path> required_path() {
  return {"given", [](const Path& path) { return !path.empty(); }};
}

Rule<std::string> required_text() {
  return {"given", [](const std::string& text) { return !text.empty(); }};
}

Rule<std::vector<double>> finite_numbers(std::size_t count) {
  return {fmt::format("{} finite numbers", count), [count](const std::vector<double>& values) {
            return values.size() == count &&
                   std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
          }};
}

}  // namespace arpent::config
