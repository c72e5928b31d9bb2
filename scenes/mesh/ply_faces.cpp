// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/ply_faces.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <sstream>
#include <string>

#include "scenes/mesh/ply_text.h"

namespace sightline {
namespace {

struct PlyProperty {
  std::string name;
  std::string type;
  std::string count_type;  // of a list

  bool is_list() const { return !count_type.empty(); }
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyLayout {
  PlyPoints::Format format = PlyPoints::Format::kAscii;
  std::vector<PlyElement> elements;
  size_t begin = 0;  // of what follows the header
};

std::optional<PlyLayout> layout_of(std::string_view ply) {
  constexpr size_t kLongest = 1 << 16;
  PlyLayout layout;
  size_t at = 0;
  while (at < std::min(ply.size(), kLongest)) {
    const size_t end = std::min(ply.find('\n', at), ply.size());
    std::istringstream words(std::string(ply.substr(at, end - at)));
    at = end + 1;
    std::string word, what, name;
    words >> word >> what >> name;
    if (word == "end_header") {
      layout.begin = std::min(at, ply.size());
      return layout;
    }
    if (word == "format" && what == "binary_little_endian") {
      layout.format = PlyPoints::Format::kLittleEndian;
    }
    if (word == "format" && what == "binary_big_endian") {
      layout.format = PlyPoints::Format::kBigEndian;
    }
    if (word == "element") {
      layout.elements.push_back({what, std::strtoull(name.c_str(), nullptr, 10), {}});
    }
    if (word != "property" || layout.elements.empty()) continue;
    PlyProperty property{name, what, ""};
    if (what == "list") {
      property.count_type = name;
      words >> property.type >> property.name;
    }
    layout.elements.back().properties.push_back(property);
  }
  return std::nullopt;
}

// Takes numbers off a file, one after the other.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view rest, PlyPoints::Format format) : rest_(rest), format_(format) {}

  bool is_torn() const { return is_torn_; }
  size_t left() const { return rest_.size(); }

  double next(const std::string& type) {
    return format_ == PlyPoints::Format::kAscii ? next_word() : next_bytes(type);
  }
  void skip(size_t bytes) {
    is_torn_ = is_torn_ || bytes > rest_.size();
    rest_.remove_prefix(std::min(bytes, rest_.size()));
  }

 private:
  double next_word() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size()));
    double number = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), number);
    if (error != std::errc()) is_torn_ = true;
    rest_.remove_prefix(static_cast<size_t>(end - rest_.data()));
    return number;
  }

  double next_bytes(const std::string& type) {
    std::array<char, 8> bytes{};
    const size_t size = bytes_of_ply_type(type);
    if (size == 0 || size > rest_.size()) {
      is_torn_ = true;
      return 0;
    }
    std::copy_n(rest_.begin(), size, bytes.begin());
    rest_.remove_prefix(size);
    if (format_ == PlyPoints::Format::kBigEndian) std::reverse(bytes.begin(), bytes.begin() + size);
    if (type.starts_with("float") || type == "double") {
      return size == 4 ? number_of<float>(bytes) : number_of<double>(bytes);
    }
    const auto raw = number_of<uint32_t>(bytes);
    if (type[0] == 'u') return raw;
    const int unused = 32 - 8 * static_cast<int>(size);
    return static_cast<int32_t>(raw << unused) >> unused;
  }

  template <typename Number>
  static Number number_of(const std::array<char, 8>& bytes) {
    Number number;
    std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }

  std::string_view rest_;
  PlyPoints::Format format_;
  bool is_torn_ = false;
};

bool has_list(const PlyElement& element) {
  return std::any_of(element.properties.begin(), element.properties.end(),
                     [](const PlyProperty& property) { return property.is_list(); });
}

int channel_of(const PlyProperty& property) {
  constexpr std::array<std::string_view, 4> kNames = {"red", "green", "blue", "alpha"};
  const auto at = std::find(kNames.begin(), kNames.end(), property.name);
  return at == kNames.end() || property.is_list() ? -1 : static_cast<int>(at - kNames.begin());
}

// What the greatest number of a type stands for is 1.
float fraction(double value, const std::string& type) {
  const size_t size = bytes_of_ply_type(type);
  const bool is_real = type.starts_with("float") || type == "double";
  const double most = is_real ? 1 : std::exp2(8 * static_cast<double>(size)) - 1;
  return static_cast<float>(std::clamp(value / most, 0.0, 1.0));
}

// Takes an element's numbers off that has no lists.
void skip_element(const PlyElement& element, bool is_ascii, PlyNumbers& numbers) {
  size_t stride = 0;
  for (const PlyProperty& property : element.properties) stride += bytes_of_ply_type(property.type);
  if (!is_ascii) {
    const bool fits = stride > 0 && element.count <= numbers.left() / stride;
    numbers.skip(fits ? element.count * stride : numbers.left() + 1);
    return;
  }
  const uint64_t count = element.count * element.properties.size();
  for (uint64_t i = 0; i < count && !numbers.is_torn(); ++i) numbers.next("");
}

// Takes a face off; its colour comes once a triangle.
void take_face(const PlyElement& face, PlyNumbers& numbers, std::vector<Eigen::Vector4f>& out) {
  Eigen::Vector4f colour(0, 0, 0, 1);
  uint64_t corners = 0;
  for (const PlyProperty& property : face.properties) {
    if (property.is_list()) {
      const double stated = numbers.next(property.count_type);
      const auto count = stated > 0 ? static_cast<uint64_t>(std::min(stated, 1e9)) : 0;
      for (uint64_t i = 0; i < count && !numbers.is_torn(); ++i) numbers.next(property.type);
      if (property.name.starts_with("vertex_ind")) corners = count;
      continue;
    }
    const double value = numbers.next(property.type);
    if (const int channel = channel_of(property); channel >= 0) {
      colour[channel] = fraction(value, property.type);
    }
  }
  if (!numbers.is_torn() && corners > 2) out.insert(out.end(), corners - 2, colour);
}

}  // namespace

PlyFaceColours ply_face_colours(std::string_view ply) {
  PlyFaceColours out;
  const auto layout = layout_of(ply);
  if (!layout) return out;
  const auto& elements = layout->elements;
  const auto face = std::find_if(elements.begin(), elements.end(),
                                 [](const PlyElement& element) { return element.name == "face"; });
  if (face == elements.end()) return out;
  out.are_there = std::any_of(face->properties.begin(), face->properties.end(),
                              [](const PlyProperty& p) { return channel_of(p) == 0; });
  if (!out.are_there || std::any_of(elements.begin(), face, has_list)) return out;
  PlyNumbers numbers(ply.substr(layout->begin), layout->format);
  const bool is_ascii = layout->format == PlyPoints::Format::kAscii;
  for (auto before = elements.begin(); before != face; ++before) {
    skip_element(*before, is_ascii, numbers);
  }
  for (uint64_t i = 0; i < face->count && !numbers.is_torn(); ++i) {
    take_face(*face, numbers, out.of_triangles);
  }
  if (numbers.is_torn()) out.of_triangles.clear();
  return out;
}

}  // namespace sightline
