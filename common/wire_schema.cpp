// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/wire_schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "common/error.h"

namespace arpent {

extern const char* const kLcmTypesText;  // generated from lcmtypes/*.lcm

namespace {

constexpr int kMaxDepth = 16;

/// Bytes of a primitive type on the wire; 0 for string and for structs.
std::size_t primitive_size(std::string_view type) {
  if (type == "int8_t" || type == "byte" || type == "boolean") return 1;
  if (type == "int16_t") return 2;
  if (type == "int32_t" || type == "float") return 4;
  if (type == "int64_t" || type == "double") return 8;
  return 0;
}

bool is_builtin(std::string_view type) {
  return type == "string" || primitive_size(type) > 0;
}

/// Splits the text into words and single signs, without comments.
class Lexer {
 public:
  explicit Lexer(std::string_view text) : text_(text) {}

  /// The next token; empty at the end.
  std::string next() {
    skip_blank();
    if (at_ >= text_.size()) return "";
    const std::size_t start = at_;
    if (!is_word(text_[at_])) return std::string(1, text_[at_++]);
    while (at_ < text_.size() && is_word(text_[at_])) ++at_;
    return std::string(text_.substr(start, at_ - start));
  }

  [[noreturn]] void fail(const std::string& what) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    throw InputError(fmt::format("LCM types, line {}: {}", line, what));
  }

  void expect(const std::string& wanted) {
    if (const std::string token = next(); token != wanted) fail(fmt::format("'{}' where '{}' belongs", token, wanted));
  }

 private:
  static bool is_word(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-' || c == '+';
  }

  void skip_blank() {
    while (at_ < text_.size()) {
      if (std::isspace(static_cast<unsigned char>(text_[at_])) != 0) {
        ++at_;
      } else if (text_.substr(at_, 2) == "//") {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (text_.substr(at_, 2) == "/*") {
        at_ = std::min(text_.find("*/", at_), text_.size() - 2) + 2;
      } else {
        return;
      }
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

struct Dimension {
  std::string size;  ///< as written: a number or a field's name
  bool variable = false;
};

struct Field {
  std::string type;
  std::string name;
  std::vector<Dimension> dimensions;
};

/// lcm-gen's hash: it sees field names, built-in types and dimensions, not struct names, constants or comments.
std::uint64_t mix(std::uint64_t hash, std::uint64_t value) {
  return ((hash << 8) ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(hash) >> 55)) + value;
}

std::uint64_t mix(std::uint64_t hash, std::string_view text) {
  hash = mix(hash, text.size());
  for (const char c : text) hash = mix(hash, static_cast<std::uint64_t>(static_cast<std::int64_t>(c)));
  return hash;
}

std::uint64_t big_endian(std::span<const std::uint8_t> bytes) {
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8 | byte;
  return value;
}

std::int64_t signed_big_endian(std::span<const std::uint8_t> bytes) {
  const auto shift = static_cast<int>(64 - 8 * bytes.size());
  return static_cast<std::int64_t>(big_endian(bytes) << shift) >> shift;
}

}  // namespace

struct WireSchema::Struct {
  std::string name;
  std::vector<Field> fields;
  std::uint64_t fingerprint = 0;
};

namespace {

void parse_constants(Lexer& lexer) {
  std::string token = lexer.next();
  while (token != ";") {
    if (token.empty()) lexer.fail("unfinished constant");
    token = lexer.next();
  }
}

Field parse_field(Lexer& lexer, const std::string& type) {
  Field field{type, lexer.next(), {}};
  std::string token = lexer.next();
  while (token == "[") {
    const std::string size = lexer.next();
    if (size.empty()) lexer.fail("unfinished dimension");
    field.dimensions.push_back({size, std::isdigit(static_cast<unsigned char>(size[0])) == 0});
    lexer.expect("]");
    token = lexer.next();
  }
  if (token != ";") lexer.fail(fmt::format("'{}' where ';' belongs", token));
  return field;
}

/// Walks one encoded message.
class Walker {
 public:
  explicit Walker(std::span<const std::uint8_t> bytes) : rest_(bytes) {}

  [[nodiscard]] std::size_t left() const { return rest_.size(); }

  template <class FindType>
  std::string walk(const std::vector<Field>& fields, const FindType& find, int depth) {
    if (depth > kMaxDepth) return "nested too deeply";
    std::map<std::string_view, std::int64_t> integers;
    for (const Field& field : fields) {
      std::uint64_t count = 1;
      if (std::string fault = count_elements(field, integers, count); !fault.empty()) return fault;
      if (std::string fault = walk_field(field, count, integers, find, depth); !fault.empty()) return fault;
    }
    return "";
  }

 private:
  std::string count_elements(const Field& field, const std::map<std::string_view, std::int64_t>& integers,
                             std::uint64_t& count) const {
    for (const Dimension& dimension : field.dimensions) {
      const std::int64_t size = dimension.variable ? integers.at(dimension.size) : std::stoll(dimension.size);
      if (size < 0) return fmt::format("{} = {} is negative", dimension.size, size);
      if (static_cast<std::uint64_t>(size) > rest_.size() && size > 0) {
        return fmt::format("{} = {} does not fit in the {} bytes left", dimension.size, size, rest_.size());
      }
      count *= static_cast<std::uint64_t>(size);
      if (count > rest_.size()) return field.name + " does not fit in the bytes left";
    }
    return "";
  }

  template <class FindType>
  std::string walk_field(const Field& field, std::uint64_t count, std::map<std::string_view, std::int64_t>& integers,
                         const FindType& find, int depth) {
    if (const std::size_t size = primitive_size(field.type); size > 0) {
      if (count > rest_.size() / size)
        return fmt::format("{} does not fit in the {} bytes left", field.name, rest_.size());
      if (field.dimensions.empty()) integers[field.name] = signed_big_endian(rest_.first(size));
      rest_ = rest_.subspan(count * size);
      return "";
    }
    for (std::uint64_t i = 0; i < count; ++i) {
      std::string fault = field.type == "string" ? walk_string(field.name) : walk(find(field.type), find, depth + 1);
      if (!fault.empty()) return fault;
    }
    return "";
  }

  std::string walk_string(const std::string& name) {
    if (rest_.size() < 4) return name + " does not fit in the bytes left";
    const std::int64_t length = signed_big_endian(rest_.first(4));
    rest_ = rest_.subspan(4);
    if (length < 1 || static_cast<std::uint64_t>(length) > rest_.size()) {
      return fmt::format("length {} of {} does not fit in the {} bytes left", length, name, rest_.size());
    }
    if (rest_[static_cast<std::size_t>(length) - 1] != 0) return name + " is not terminated";
    rest_ = rest_.subspan(static_cast<std::size_t>(length));
    return "";
  }

  std::span<const std::uint8_t> rest_;
};

}  // namespace

WireSchema::WireSchema(std::string_view lcm_text) {
  Lexer lexer(lcm_text);
  for (std::string token = lexer.next(); !token.empty(); token = lexer.next()) {
    if (token == "package") {
      lexer.next();
      lexer.expect(";");
      continue;
    }
    if (token != "struct") lexer.fail(fmt::format("'{}' where 'struct' belongs", token));
    auto type = std::make_unique<Struct>();
    type->name = lexer.next();
    lexer.expect("{");
    for (token = lexer.next(); token != "}"; token = lexer.next()) {
      if (token.empty()) lexer.fail("unfinished struct " + type->name);
      if (token == "const") {
        parse_constants(lexer);
      } else {
        type->fields.push_back(parse_field(lexer, token));
      }
    }
    types_[type->name] = std::move(type);
  }
  for (const auto& [name, type] : types_) {
    for (const Field& field : type->fields) {
      if (!is_builtin(field.type) && !types_.contains(field.type)) lexer.fail(name + ": unknown type " + field.type);
    }
  }
  for (const auto& [name, type] : types_) {
    std::vector<const Struct*> parents;
    type->fingerprint = compute_fingerprint(*type, parents);
  }
}

WireSchema::~WireSchema() = default;

std::uint64_t WireSchema::compute_fingerprint(const Struct& type, std::vector<const Struct*>& parents) const {
  if (std::find(parents.begin(), parents.end(), &type) != parents.end()) return 0;
  parents.push_back(&type);
  std::uint64_t hash = 0x12345678;
  std::uint64_t children = 0;
  for (const Field& field : type.fields) {
    hash = mix(hash, field.name);
    if (is_builtin(field.type)) {
      hash = mix(hash, field.type);
    } else {
      children += compute_fingerprint(*types_.find(field.type)->second, parents);
    }
    hash = mix(hash, field.dimensions.size());
    for (const Dimension& dimension : field.dimensions) {
      hash = mix(mix(hash, dimension.variable ? 1 : 0), dimension.size);
    }
  }
  parents.pop_back();
  hash += children;
  return (hash << 1) + (hash >> 63);
}

std::uint64_t WireSchema::fingerprint(std::string_view type) const {
  const auto found = types_.find(type);
  if (found == types_.end()) throw InputError(fmt::format("there is no LCM type {}", type));
  return found->second->fingerprint;
}

std::vector<std::string> WireSchema::type_names() const {
  std::vector<std::string> names;
  for (const auto& entry : types_) names.push_back(entry.first);
  return names;
}

std::string WireSchema::type_of(std::span<const std::uint8_t> bytes) const {
  if (bytes.size() < 8) return "";
  const std::uint64_t fingerprint = big_endian(bytes.first(8));
  for (const auto& [name, type] : types_) {
    if (type->fingerprint == fingerprint) return name;
  }
  return "";
}

std::optional<std::string> WireSchema::check(std::string_view type, std::span<const std::uint8_t> bytes) const {
  const auto found = types_.find(type);
  if (found == types_.end()) return fmt::format("there is no LCM type {}", type);
  if (bytes.size() < 8) return "shorter than a fingerprint";
  if (big_endian(bytes.first(8)) != found->second->fingerprint) {
    return fmt::format("its fingerprint is not that of {}: another type, or another version of it", type);
  }
  Walker walker(bytes.subspan(8));
  const auto find = [this](const std::string& name) -> const std::vector<Field>& {
    return types_.find(name)->second->fields;
  };
  std::string fault = walker.walk(found->second->fields, find, 0);
  if (!fault.empty()) return fault;
  if (walker.left() > 0) return fmt::format("{} bytes too many", walker.left());
  return std::nullopt;
}

const WireSchema& wire_schema() {
  static const WireSchema schema(kLcmTypesText);
  return schema;
}

}  // namespace arpent
