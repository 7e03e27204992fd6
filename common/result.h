// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A value, or the sentence why there is none: what conversions from the wire return.
#pragma once

#include <optional>
#include <string>
#include <utility>

namespace arpent {

struct Fault {
  std::string text;
};

template <class T>
class Result {
 public:
  Result(T value) : value_(std::move(value)) {}  // NOLINT(google-explicit-constructor): returned by value or fault
  Result(Fault fault) : fault_(std::move(fault.text)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] explicit operator bool() const { return value_.has_value(); }
  [[nodiscard]] const T& operator*() const { return *value_; }
  [[nodiscard]] T& operator*() { return *value_; }
  [[nodiscard]] const T* operator->() const { return &*value_; }
  /// Empty if there is a value.
  [[nodiscard]] const std::string& fault() const { return fault_; }

 private:
  std::optional<T> value_;
  std::string fault_;
};

}  // namespace arpent
