// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/tour/tsplib.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>

#include "common/error.h"

namespace arpent::tour {
namespace {

/// A matrix of this size takes 200 MB.
constexpr int kMostNodes = 5000;

std::string trim(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::optional<double> to_number(const std::string& word) {
  double value = 0;
  const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);
  const auto [end, fault] = std::from_chars(begin, word.data() + word.size(), value);
  if (fault != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

class Parser {
 public:
  Parser(const std::string& text, const std::string& name) : in_(text), name_(name) {}

  TsplibProblem parse() {
    problem_.name = name_;
    std::string line;
    while (next_line(line)) {
      const std::string key = trim(line.substr(0, line.find(':')));
      if (key.empty()) continue;
      if (key == "EOF") break;
      if (key == "EDGE_WEIGHT_SECTION") {
        read_weights();
      } else {
        const auto colon = line.find(':');
        if (colon == std::string::npos) fail("'" + key.substr(0, 40) + "' is neither 'KEY : VALUE' nor a section");
        specify(key, trim(line.substr(colon + 1)));
      }
    }
    if (!has_weights_) fail("there is no EDGE_WEIGHT_SECTION");
    return std::move(problem_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(name_ + ":" + std::to_string(line_) + ": " + what);
  }

  bool next_line(std::string& line) {
    if (!std::getline(in_, line)) return false;
    ++line_;
    return true;
  }

  void specify(const std::string& key, const std::string& value) {
    const auto demand = [&](const std::string& wanted) {
      if (value != wanted) fail(key + " is '" + value + "'; only " + wanted + " can be read");
    };
    if (key == "NAME") {
      problem_.name = value;
    } else if (key == "TYPE") {
      if (value != "ATSP" && value != "TSP") fail("TYPE is '" + value + "'; only ATSP and TSP can be read");
    } else if (key == "EDGE_WEIGHT_TYPE") {
      demand("EXPLICIT");
      explicit_ = true;
    } else if (key == "EDGE_WEIGHT_FORMAT") {
      demand("FULL_MATRIX");
      full_ = true;
    } else if (key == "DIMENSION") {
      const std::optional<double> number = to_number(value);
      if (!number || *number != std::floor(*number) || *number < 1 || *number > kMostNodes) {
        fail("DIMENSION is '" + value + "', must be a whole number from 1 to " + std::to_string(kMostNodes));
      }
      nodes_ = static_cast<Eigen::Index>(*number);
    } else if (key != "COMMENT" && key != "DISPLAY_DATA_TYPE" && key != "NODE_COORD_TYPE") {
      fail("'" + key.substr(0, 40) + "' is not understood");
    }
  }

  void read_weights() {
    if (has_weights_) fail("there is a second EDGE_WEIGHT_SECTION");
    if (nodes_ == 0) fail("DIMENSION must come before EDGE_WEIGHT_SECTION");
    if (!explicit_) fail("EDGE_WEIGHT_TYPE: EXPLICIT must come before EDGE_WEIGHT_SECTION");
    if (!full_) fail("EDGE_WEIGHT_FORMAT: FULL_MATRIX must come before EDGE_WEIGHT_SECTION");
    has_weights_ = true;
    problem_.cost.resize(nodes_, nodes_);
    const Eigen::Index wanted = nodes_ * nodes_;
    std::string line;
    for (Eigen::Index count = 0; count < wanted;) {
      if (!next_line(line)) fail(missing(count, wanted));
      std::istringstream words(line);
      for (std::string word; words >> word; ++count) {
        if (word == "EOF") fail(missing(count, wanted));
        if (count == wanted) fail("more than DIMENSION x DIMENSION = " + std::to_string(wanted) + " weights");
        set(count, word);
      }
    }
    refuse_more(wanted);
  }

  static std::string missing(Eigen::Index count, Eigen::Index wanted) {
    return "the file ends after " + std::to_string(count) + " of " + std::to_string(wanted) + " weights";
  }

  void set(Eigen::Index count, const std::string& word) {
    const std::optional<double> number = to_number(word);
    if (!number) fail("'" + word.substr(0, 40) + "' is not a number");
    const Eigen::Index row = count / nodes_, column = count % nodes_;
    problem_.cost(row, column) = row == column ? 0 : *number;
    if (row != column && *number != std::floor(*number)) problem_.whole_numbers = false;
  }

  /// Numbers behind the last weight mean that DIMENSION is wrong.
  void refuse_more(Eigen::Index wanted) {
    const auto here = in_.tellg();
    std::string word;
    if (in_ >> word && to_number(word)) {
      fail("more than DIMENSION x DIMENSION = " + std::to_string(wanted) + " weights");
    }
    in_.clear();
    in_.seekg(here);
  }

  std::istringstream in_;
  std::string name_;
  int line_ = 0;
  TsplibProblem problem_;
  Eigen::Index nodes_ = 0;
  bool explicit_ = false, full_ = false, has_weights_ = false;
};

}  // namespace

TsplibProblem parse_tsplib(const std::string& text, const std::string& name) {
  return Parser(text, name).parse();
}

TsplibProblem read_tsplib(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (!std::filesystem::is_regular_file(file) || !in || !(text << in.rdbuf())) {
    throw InputError(file.string() + ": cannot be read");
  }
  return parse_tsplib(text.str(), file.string());
}

}  // namespace arpent::tour
