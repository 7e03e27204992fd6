// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/can_mock/mock.h"

#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>

namespace arpent::tools {
namespace {

using base::EncoderFault;
using base::Side;

std::optional<Side> to_side(const std::string& word) {
  if (word == "left") return Side::kLeft;
  if (word == "right") return Side::kRight;
  return std::nullopt;
}

bool set_encoder(base::WheelMotors& motors, const std::string& side_word, const std::string& fault_word) {
  static const std::map<std::string, EncoderFault> kFaults{{"ok", EncoderFault::kNone},
                                                           {"stuck", EncoderFault::kStuck},
                                                           {"reversed", EncoderFault::kReversed},
                                                           {"doubled", EncoderFault::kDoubled}};
  const auto side = to_side(side_word);
  const auto fault = kFaults.find(fault_word);
  if (!side || fault == kFaults.end()) return false;
  motors.set_encoder_fault(*side, fault->second);
  return true;
}

bool set_count(base::WheelMotors& motors, const std::string& side_word, const std::string& count_word) {
  const auto side = to_side(side_word);
  const auto count = to_number(count_word);
  if (!side || !count || std::abs(*count) > 2147483647.0) return false;
  motors.set_count(*side, static_cast<std::int32_t>(*count));
  return true;
}

bool set_slip(base::WheelMotors& motors, const std::string& left_word, const std::string& right_word) {
  const auto left = to_number(left_word), right = to_number(right_word);
  const auto share = [](const std::optional<double>& v) { return v && *v >= 0 && *v <= 1; };
  if (!share(left) || !share(right)) return false;
  motors.set_slip(*left, *right);
  return true;
}

}  // namespace

std::optional<double> to_number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value)) return std::nullopt;
  return value;
}

bool Mock::apply(const std::string& event) {
  std::istringstream in(event);
  Words words;
  for (std::string word; in >> word;) words.push_back(word);
  if (words.size() == 3 && words[0] == "slip") return set_slip(motors(), words[1], words[2]);
  if (words.size() == 3 && words[0] == "encoder") return set_encoder(motors(), words[1], words[2]);
  if (words.size() == 3 && words[0] == "count") return set_count(motors(), words[1], words[2]);
  if (words.size() == 2 && words[0] == "block" && (words[1] == "on" || words[1] == "off")) {
    motors().set_blocked(words[1] == "on");
    return true;
  }
  return !words.empty() && apply_own(words);
}

std::unique_ptr<Mock> make_mock(const MockOptions& options, const Now& now) {
  return options.base.protocol == "wifibot" ? make_wifibot_mock(options, now) : make_agilex_mock(options, now);
}

}  // namespace arpent::tools
