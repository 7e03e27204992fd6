// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What the .lcm files say, at run time: the guard that walks an encoded message before the generated decoder sees a
// byte (stock decoders trust counts and lengths), and each type's fingerprint, computed independently of lcm-gen. The
// files' text is built in.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace arpent {

class WireSchema {
 public:
  /// Parses LCM type definitions. Throws InputError with line and reason if they are not understood.
  explicit WireSchema(std::string_view lcm_text);
  ~WireSchema();

  /// nullopt if `bytes` (fingerprint first) can be decoded as `type`: right fingerprint, every count non-negative and
  /// fitting in what is left, strings terminated, nothing left over. Otherwise what is wrong.
  [[nodiscard]] std::optional<std::string> check(std::string_view type, std::span<const std::uint8_t> bytes) const;

  /// The 64 bits that LCM puts before a message of this type. Throws InputError for an unknown type.
  [[nodiscard]] std::uint64_t fingerprint(std::string_view type) const;
  /// The type whose fingerprint leads `bytes`; empty if it is none of ours.
  [[nodiscard]] std::string type_of(std::span<const std::uint8_t> bytes) const;
  [[nodiscard]] std::vector<std::string> type_names() const;

 private:
  struct Struct;
  [[nodiscard]] std::uint64_t compute_fingerprint(const Struct& type, std::vector<const Struct*>& parents) const;
  std::map<std::string, std::unique_ptr<Struct>, std::less<>> types_;
};

/// The project's own types.
[[nodiscard]] const WireSchema& wire_schema();

}  // namespace arpent
