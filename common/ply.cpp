// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "common/atomic_file.h"
#include "common/error.h"
#include "common/mesh.h"

namespace arpent {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what) {
  throw InputError(file.string() + ": is no PLY file that can be read: " + what);
}

template <class T>
void append(std::vector<std::byte>& buffer, const T& value) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&value);
  buffer.insert(buffer.end(), bytes, bytes + sizeof(T));
}

struct Property {
  std::string name;
  std::string type;
  std::string count_type;  ///< of a list; empty otherwise
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

std::size_t size_of(const std::string& type) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "float" || type == "int32" || type == "uint32" || type == "float32")
    return 4;
  if (type == "double" || type == "float64") return 8;
  return 0;
}

/// Reads values one after another, from text or from binary data of either byte order.
class Values {
 public:
  Values(std::string_view data, const std::string& format)
      : data_(data), ascii_(format == "ascii"), swap_(format == "binary_big_endian") {}

  [[nodiscard]] std::size_t left() const { return data_.size(); }

  /// False at the end of the data.
  bool read(const std::string& type, double& value) { return ascii_ ? read_text(value) : read_binary(type, value); }

 private:
  bool read_text(double& value) {
    const auto start = data_.find_first_not_of(" \t\r\n");
    if (start == std::string_view::npos) return false;
    const auto end = std::min(data_.find_first_of(" \t\r\n", start), data_.size());
    const std::string word(data_.substr(start, end - start));
    char* stop = nullptr;
    value = std::strtod(word.c_str(), &stop);
    data_.remove_prefix(end);
    return *stop == '\0' && stop != word.c_str();
  }

  bool read_binary(const std::string& type, double& value) {
    const std::size_t size = size_of(type);
    if (size == 0 || data_.size() < size) return false;
    char bytes[8];
    for (std::size_t i = 0; i < size; ++i) bytes[swap_ ? size - 1 - i : i] = data_[i];
    data_.remove_prefix(size);
    const auto as = [&](auto sample) {
      std::memcpy(&sample, bytes, sizeof sample);
      return static_cast<double>(sample);
    };
    if (type[0] == 'f')
      value = as(float{});
    else if (type[0] == 'd')
      value = as(double{});
    else if (size == 1)
      value = type[0] == 'u' ? as(std::uint8_t{}) : as(std::int8_t{});
    else if (size == 2)
      value = type[0] == 'u' ? as(std::uint16_t{}) : as(std::int16_t{});
    else
      value = type[0] == 'u' ? as(std::uint32_t{}) : as(std::int32_t{});
    if (type == "float64") value = as(double{});
    return true;
  }

  std::string_view data_;
  bool ascii_;
  bool swap_;
};

struct Header {
  std::string format;
  std::vector<Element> elements;
  std::size_t end = 0;
};

Header read_header(const std::string& content, const std::filesystem::path& file) {
  Header header;
  std::size_t at = 0;
  for (int number = 0;; ++number) {
    const auto end = content.find('\n', at);
    if (end == std::string::npos) fail(file, "the header has no end");
    std::istringstream line(content.substr(at, end - at));
    at = end + 1;
    std::string word;
    line >> word;
    if (number == 0 && word != "ply") fail(file, "it does not begin with `ply`");
    if (word == "format") line >> header.format;
    if (word == "element") {
      Element element;
      if (!(line >> element.name >> element.count)) fail(file, "an element without a count");
      header.elements.push_back(element);
    }
    if (word == "property") {
      Property property;
      line >> property.type;
      if (property.type == "list") line >> property.count_type >> property.type;
      line >> property.name;
      if (header.elements.empty() || size_of(property.type) == 0 ||
          (!property.count_type.empty() && size_of(property.count_type) == 0)) {
        fail(file, "a property of an unknown type");
      }
      header.elements.back().properties.push_back(property);
    }
    if (word == "end_header") break;
  }
  if (header.format != "ascii" && !header.format.starts_with("binary_")) fail(file, "unknown format " + header.format);
  header.end = at;
  return header;
}

class Reader {
 public:
  Reader(const std::string& content, std::filesystem::path file)
      : file_(std::move(file)),
        header_(read_header(content, file_)),
        values_(std::string_view(content).substr(header_.end), header_.format) {}

  TriangleMesh run() {
    for (const Element& element : header_.elements) {
      // Each item takes at least a byte: a count that cannot fit is refused before anything is reserved.
      if (element.count > values_.left() && !element.properties.empty())
        fail(file_, element.name + " count does not fit the file");
      for (std::uint64_t i = 0; i < element.count; ++i) read_item(element);
    }
    if (!normals_) mesh_.normals.clear();
    if (!colors_) mesh_.colors_rgb.clear();
    for (const auto& triangle : mesh_.triangles) {
      for (const std::uint32_t i : triangle) {
        if (i >= mesh_.vertices_m.size()) fail(file_, "a face names a vertex that is not there");
      }
    }
    return std::move(mesh_);
  }

 private:
  double value(const std::string& type) {
    double v = 0;
    if (!values_.read(type, v)) fail(file_, "the data ends too early");
    return v;
  }

  void read_item(const Element& element) {
    Eigen::Vector3f p = Eigen::Vector3f::Zero();
    Eigen::Vector3f n = Eigen::Vector3f::Zero();
    std::array<std::uint8_t, 3> c{};
    for (const Property& property : element.properties) {
      if (!property.count_type.empty()) {
        read_list(element, property);
        continue;
      }
      const double v = value(property.type);
      const auto f = static_cast<float>(v);
      if (property.name == "x") p.x() = f;
      if (property.name == "y") p.y() = f;
      if (property.name == "z") p.z() = f;
      if (property.name == "nx") {
        n.x() = f;
        normals_ = normals_ || element.name == "vertex";
      }
      if (property.name == "ny") n.y() = f;
      if (property.name == "nz") n.z() = f;
      const auto byte = static_cast<std::uint8_t>(std::min(255.0, std::max(0.0, v)));
      if (property.name == "red") {
        c[0] = byte;
        colors_ = colors_ || element.name == "vertex";
      }
      if (property.name == "green") c[1] = byte;
      if (property.name == "blue") c[2] = byte;
    }
    if (element.name != "vertex") return;
    if (!p.allFinite()) fail(file_, "a vertex is not finite");
    mesh_.vertices_m.push_back(p);
    mesh_.normals.push_back(n);
    mesh_.colors_rgb.push_back(c);
  }

  void read_list(const Element& element, const Property& property) {
    const double count = value(property.count_type);
    if (!(count >= 0) || count > static_cast<double>(values_.left())) fail(file_, "a list is longer than the file");
    std::vector<std::uint32_t> corners;
    for (double i = 0; i < count; ++i) {
      const double v = value(property.type);
      if (!(v >= 0 && v < 4294967295.0)) fail(file_, "a face names a vertex that is not there");
      corners.push_back(static_cast<std::uint32_t>(v));
    }
    if (element.name != "face" || (property.name != "vertex_indices" && property.name != "vertex_index")) return;
    for (std::size_t i = 2; i < corners.size(); ++i)
      mesh_.triangles.push_back({corners[0], corners[i - 1], corners[i]});
  }

  std::filesystem::path file_;
  Header header_;
  Values values_;
  TriangleMesh mesh_;
  bool normals_ = false;
  bool colors_ = false;
};

}  // namespace

void write_ply(const std::filesystem::path& path, const TriangleMesh& mesh) {
  const bool normals = mesh.normals.size() == mesh.vertices_m.size() && !mesh.normals.empty();
  const bool colors = mesh.colors_rgb.size() == mesh.vertices_m.size() && !mesh.colors_rgb.empty();
  std::string header = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n",
      mesh.vertices_m.size());
  if (normals) header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (colors) header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  header +=
      fmt::format("element face {}\nproperty list uchar uint vertex_indices\nend_header\n", mesh.triangles.size());
  std::vector<std::byte> body;
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    for (int k = 0; k < 3; ++k) append(body, mesh.vertices_m[i][k]);
    for (int k = 0; normals && k < 3; ++k) append(body, mesh.normals[i][k]);
    for (std::size_t k = 0; colors && k < 3; ++k) append(body, mesh.colors_rgb[i][k]);
  }
  for (const auto& triangle : mesh.triangles) {
    append(body, std::uint8_t{3});
    for (const std::uint32_t i : triangle) append(body, i);
  }
  atomic_write(path, [&](const WriteBytes& write) {
    write(std::as_bytes(std::span(header)));
    write(body);
  });
}

TriangleMesh read_ply(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream content;
  if (!in || std::filesystem::is_directory(path) || !(content << in.rdbuf()))
    throw InputError(path.string() + ": cannot be read");
  return Reader(content.str(), path).run();
}

}  // namespace arpent
