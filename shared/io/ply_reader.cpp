// Reads PLY of any flavour; no count of the header is believed before the bytes for it are there.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>
#include <vector>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/ply.h"
#include "shared/io/text_lines.h"

namespace kt {
namespace {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct TypeName {
  const char *name, *sized_name;
  Type type;
  size_t size;
};
constexpr TypeName kTypes[] = {
    {"char", "int8", Type::kInt8, 1},      {"uchar", "uint8", Type::kUint8, 1},
    {"short", "int16", Type::kInt16, 2},   {"ushort", "uint16", Type::kUint16, 2},
    {"int", "int32", Type::kInt32, 4},     {"uint", "uint32", Type::kUint32, 4},
    {"float", "float32", Type::kFloat, 4}, {"double", "float64", Type::kDouble, 8}};

constexpr size_t size_of(Type type) { return kTypes[static_cast<size_t>(type)].size; }

/// What a property means to us.
enum class Role { kNone, kX, kY, kZ, kNx, kNy, kNz, kRed, kGreen, kBlue, kQuality, kCorners, kCount };
constexpr const char* kRoleNames[] = {"",   "x",   "y",     "z",    "nx",      "ny",
                                      "nz", "red", "green", "blue", "quality", "vertex_indices"};

struct Property {
  Type type = Type::kFloat;
  Type count_type = Type::kUint8;  ///< of lists
  bool is_list = false;
  Role role = Role::kNone;
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;
  bool has(Role role) const {
    return std::any_of(properties.begin(), properties.end(),
                       [&](const Property& p) { return p.role == role; });
  }
};

class PlyReader {
 public:
  PlyReader(std::span<const uint8_t> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  Mesh read() {
    read_header();
    for (const Element& element : elements_) {
      check_count(element);
      if (element.name == "vertex") {
        read_vertices(element);
      } else if (element.name == "face") {
        read_faces(element);
      } else {
        for (uint64_t i = 0; i < element.count; ++i) read_record(element);
      }
    }
    for (const auto& triangle : mesh_.triangles) {
      for (const uint32_t corner : triangle) {
        if (corner >= mesh_.vertices.size()) fail("a face points beyond the last vertex");
      }
    }
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw Error(name_ + ": " + what); }

  Type type_named(std::string_view text) const {
    for (const TypeName& candidate : kTypes) {
      if (text == candidate.name || text == candidate.sized_name) return candidate.type;
    }
    fail("unknown PLY type " + std::string(text));
  }

  void read_header() {
    const std::string_view text = as_text(bytes_);
    if (!text.starts_with("ply\n") && !text.starts_with("ply\r\n")) fail("is not a PLY file");
    bool has_format = false;
    TextLines lines(name_, text);
    while (lines.next()) {
      const auto& fields = lines.fields();
      const std::string_view keyword = fields[0];
      if (keyword == "format") {
        lines.expect_fields(3, "format <encoding> 1.0");
        has_format = true;
        is_ascii_ = fields[1] == "ascii";
        is_big_endian_ = fields[1] == "binary_big_endian";
        if (!is_ascii_ && !is_big_endian_ && fields[1] != "binary_little_endian")
          lines.fail("unknown encoding");
      } else if (keyword == "element") {
        lines.expect_fields(3, "element <name> <count>");
        const int64_t count = lines.integer(2);
        if (count < 0) lines.fail("the count is negative");
        elements_.push_back({std::string(fields[1]), static_cast<uint64_t>(count), {}});
      } else if (keyword == "property") {
        if (elements_.empty()) lines.fail("a property before the first element");
        elements_.back().properties.push_back(read_property(lines));
      } else if (keyword == "end_header") {
        if (!has_format) lines.fail("the format line is missing");
        offset_ = static_cast<size_t>(fields[0].data() + fields[0].size() - text.data());
        if (offset_ < text.size() && text[offset_] == '\r') ++offset_;
        if (offset_ < text.size() && text[offset_] == '\n') ++offset_;
        return;
      }
    }
    fail("the PLY header has no end");
  }

  Property read_property(const TextLines& lines) const {
    const auto& fields = lines.fields();
    Property property;
    property.is_list = fields.size() > 1 && fields[1] == "list";
    lines.expect_fields(property.is_list ? 5 : 3, "property [list <count type>] <type> <name>");
    if (property.is_list) property.count_type = type_named(fields[2]);
    if (property.count_type >= Type::kFloat) lines.fail("a list is counted in whole numbers");
    property.type = type_named(fields[fields.size() - 2]);
    const std::string_view name = fields.back() == "vertex_index" ? "vertex_indices" : fields.back();
    for (int role = 1; role < static_cast<int>(Role::kCount); ++role) {
      const bool takes_list = static_cast<Role>(role) == Role::kCorners;
      if (name == kRoleNames[role] && takes_list == property.is_list) property.role = static_cast<Role>(role);
    }
    return property;
  }

  /// Each value takes its size, or in ASCII a digit and a blank (but the last), so that a damaged count shows
  /// at once.
  void check_count(const Element& element) const {
    size_t least = 0;
    for (const Property& property : element.properties) {
      least += is_ascii_ ? 2 : size_of(property.is_list ? property.count_type : property.type);
    }
    if (least == 0 && element.count > 0) fail("no properties in element " + element.name);
    if (element.count > 0 && element.count > (bytes_.size() - offset_ + 1) / least) {
      fail(std::string("is truncated: ") + std::to_string(element.count) + " of element '" + element.name +
           "' do not fit");
    }
  }

  template <typename T>
  double read_as() {
    if (sizeof(T) > bytes_.size() - offset_) fail("is truncated");
    std::array<uint8_t, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + offset_, sizeof(T));
    offset_ += sizeof(T);
    if (is_big_endian_) std::reverse(raw.begin(), raw.end());
    return static_cast<double>(std::bit_cast<T>(raw));
  }

  double read_value(Type type) {
    if (is_ascii_) return read_ascii();
    switch (type) {
      case Type::kInt8:
        return read_as<int8_t>();
      case Type::kUint8:
        return read_as<uint8_t>();
      case Type::kInt16:
        return read_as<int16_t>();
      case Type::kUint16:
        return read_as<uint16_t>();
      case Type::kInt32:
        return read_as<int32_t>();
      case Type::kUint32:
        return read_as<uint32_t>();
      case Type::kFloat:
        return read_as<float>();
      case Type::kDouble:
        return read_as<double>();
    }
    return 0;
  }

  double read_ascii() {
    constexpr std::string_view kBlanks = " \t\r\n";
    const std::string_view text = as_text(bytes_);
    const size_t begin = std::min(text.find_first_not_of(kBlanks, offset_), text.size());
    const size_t end = std::min(text.find_first_of(kBlanks, begin), text.size());
    if (begin == end) fail("is truncated");
    offset_ = end;
    const std::optional<double> value = parse_number(text.substr(begin, end - begin));
    if (!value) fail("not a number: " + std::string(text.substr(begin, std::min<size_t>(end - begin, 40))));
    return *value;
  }

  /// One record of an element: its scalars go to values_ by role, a face's corners to corners_.
  void read_record(const Element& element) {
    for (const Property& property : element.properties) {
      if (!property.is_list) {
        values_[static_cast<size_t>(property.role)] = read_value(property.type);
        continue;
      }
      const double count = read_value(property.count_type);
      // Written so that NaN fails; ASCII allows it and fractions.
      if (!(count >= 0 && count <= static_cast<double>(bytes_.size() - offset_))) fail("a list does not fit");
      if (property.role == Role::kCorners) corners_.clear();
      for (uint64_t k = 0; k < static_cast<uint64_t>(count); ++k) {
        const double value = read_value(property.type);
        if (property.role == Role::kCorners) corners_.push_back(value);
      }
    }
  }

  double value(Role role) const { return values_[static_cast<size_t>(role)]; }
  Vec3f vector(Role first) const {
    const size_t i = static_cast<size_t>(first);
    return {static_cast<float>(values_[i]), static_cast<float>(values_[i + 1]),
            static_cast<float>(values_[i + 2])};
  }

  void read_vertices(const Element& element) {
    if (!element.has(Role::kX) || !element.has(Role::kY) || !element.has(Role::kZ))
      fail("vertices without x, y and z");
    const bool has_normals = element.has(Role::kNx) && element.has(Role::kNy) && element.has(Role::kNz);
    const bool has_colours = element.has(Role::kRed) && element.has(Role::kGreen) && element.has(Role::kBlue);
    const bool has_quality = element.has(Role::kQuality);
    // Floating-point colours run from 0 to 1.
    double colour_scale = 1;
    for (const Property& property : element.properties) {
      if (property.role == Role::kRed && property.type >= Type::kFloat) colour_scale = 255;
    }
    const auto channel = [&](Role role) {
      const double level = value(role) * colour_scale;
      return static_cast<uint8_t>(level >= 0 ? std::min(level + 0.5, 255.0) : 0.0);
    };
    mesh_ = Mesh{
        .vertices = {}, .normals = {}, .colours = {}, .quality = {}, .triangles = std::move(mesh_.triangles)};
    mesh_.vertices.reserve(element.count);
    for (uint64_t i = 0; i < element.count; ++i) {
      read_record(element);
      const Vec3f p = vector(Role::kX);
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) fail("a vertex is not finite");
      mesh_.vertices.push_back(p);
      if (has_normals) mesh_.normals.push_back(vector(Role::kNx));
      if (has_colours)
        mesh_.colours.push_back({channel(Role::kRed), channel(Role::kGreen), channel(Role::kBlue)});
      if (has_quality) mesh_.quality.push_back(static_cast<float>(value(Role::kQuality)));
    }
  }

  void read_faces(const Element& element) {
    if (!element.has(Role::kCorners)) fail("faces without vertex_indices");
    for (uint64_t i = 0; i < element.count; ++i) {
      read_record(element);
      for (const double corner : corners_) {
        if (!(corner >= 0 && corner <= 4294967295.0)) fail("a face points beyond the last vertex");
      }
      for (size_t k = 2; k < corners_.size(); ++k) {
        mesh_.triangles.push_back({static_cast<uint32_t>(corners_[0]), static_cast<uint32_t>(corners_[k - 1]),
                                   static_cast<uint32_t>(corners_[k])});
      }
    }
  }

  std::span<const uint8_t> bytes_;
  const std::string& name_;
  size_t offset_ = 0;
  bool is_ascii_ = false, is_big_endian_ = false;
  std::vector<Element> elements_;
  std::array<double, static_cast<size_t>(Role::kCount)> values_{};
  std::vector<double> corners_;
  Mesh mesh_;
};

}  // namespace

Mesh mesh_from_ply(std::span<const uint8_t> bytes, const std::string& name) {
  return PlyReader(bytes, name).read();
}

Mesh read_ply(const std::filesystem::path& path) {
  return mesh_from_ply(as_bytes(read_file(path)), path.string());
}

}  // namespace kt
