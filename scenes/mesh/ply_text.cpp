// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/ply_text.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <map>
#include <sstream>
#include <system_error>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "scenes/mesh/obj_text.h"

namespace sightline {
namespace {

// Takes a line off the text, without its end.
std::string_view next_line(std::string_view& text) {
  const size_t end = std::min(text.find('\n'), text.size());
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

// What the header says, line by line.
struct PlyHeader {
  PlyPoints points;
  int elements = 0;
  int properties = 0;             // of the vertices, so far
  std::array<bool, 3> is_seen{};  // x, y and z
  std::array<bool, 3> is_double{};
  bool is_known = true;

  void read(const std::string& line) {
    std::istringstream words(line);
    std::string word, what, name;
    words >> word >> what >> name;
    if (word == "format") read_format(what);
    if (word == "element") {
      ++elements;
      if (elements == 1) is_known = what == "vertex" && read_count(name);
    }
    if (word == "property" && elements == 1) read_property(what, name);
  }

  void read_format(const std::string& what) {
    if (what == "binary_little_endian") points.format = PlyPoints::Format::kLittleEndian;
    if (what == "binary_big_endian") points.format = PlyPoints::Format::kBigEndian;
  }

  bool read_count(const std::string& text) {
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, points.count);
    return error == std::errc() && rest == end;
  }

  void read_property(const std::string& type, const std::string& name) {
    const size_t bytes = bytes_of_ply_type(type);
    is_known = is_known && bytes > 0;
    const bool is_axis = name == "x" || name == "y" || name == "z";
    if (is_axis) {
      const bool is_ascii = points.format == PlyPoints::Format::kAscii;
      const auto axis = static_cast<size_t>(name[0] - 'x');
      if (is_seen[axis]) is_known = false;  // a file that has an axis twice is not moved
      is_seen[axis] = true;
      is_double[axis] = bytes == 8;
      points.place[axis] = is_ascii ? static_cast<size_t>(properties) : points.stride;
    }
    points.stride += bytes;
    ++properties;
  }
};

// The numbers of a vertex of a binary file.
double number_at(const char* at, PlyPoints::Format format) {
  uint64_t bits = 0;
  std::memcpy(&bits, at, sizeof bits);
  if (format == PlyPoints::Format::kBigEndian) bits = __builtin_bswap64(bits);
  return std::bit_cast<double>(bits);
}

void put_number(double number, PlyPoints::Format format, char* at) {
  auto bits = std::bit_cast<uint64_t>(number);
  if (format == PlyPoints::Format::kBigEndian) bits = __builtin_bswap64(bits);
  std::memcpy(at, &bits, sizeof bits);
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return words;
    const size_t end = std::min(line.find_first_of(" \t", begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    line.remove_prefix(end);
  }
}

std::optional<Eigen::Vector3d> ascii_vertex(const std::vector<std::string_view>& words,
                                            const PlyPoints& points) {
  Eigen::Vector3d x;
  for (size_t axis = 0; axis < 3; ++axis) {
    if (points.place[axis] >= words.size()) return std::nullopt;
    std::string_view word = words[points.place[axis]];
    if (word.starts_with('+')) word.remove_prefix(1);
    const char* const end = word.data() + word.size();
    const auto [rest, error] = std::from_chars(word.data(), end, x[static_cast<int>(axis)]);
    if (error != std::errc() || rest != end) return std::nullopt;
  }
  return x;
}

bool is_whole(const PlyPoints& points, std::string_view ply) {
  return points.stride > 0 && points.count <= (ply.size() - points.begin) / points.stride;
}

// Calls with every vertex; false where the file ends before, or has something else.
template <typename Visit>
bool for_each_vertex(const PlyPoints& points, std::string_view ply, const Visit& visit) {
  std::string_view rest = ply.substr(points.begin);
  if (points.format == PlyPoints::Format::kAscii) {
    for (size_t i = 0; i < points.count; ++i) {
      if (rest.empty()) return false;
      const auto vertex = ascii_vertex(words_of(next_line(rest)), points);
      if (!vertex) return false;
      visit(*vertex);
    }
    return true;
  }
  if (!is_whole(points, ply)) return false;
  for (size_t i = 0; i < points.count; ++i) {
    const char* const at = rest.data() + i * points.stride;
    visit(Eigen::Vector3d(number_at(at + points.place[0], points.format),
                          number_at(at + points.place[1], points.format),
                          number_at(at + points.place[2], points.format)));
  }
  return true;
}

std::string moved_ascii(std::string_view ply, const PlyPoints& points, const Eigen::Vector3d& by) {
  std::string out(ply.substr(0, points.begin));
  out.reserve(ply.size());
  std::string_view rest = ply.substr(points.begin);
  for (size_t i = 0; i < points.count; ++i) {
    const auto words = words_of(next_line(rest));
    const Eigen::Vector3d x = *ascii_vertex(words, points) - by;
    for (size_t w = 0; w < words.size(); ++w) {
      const auto axis = std::find(points.place.begin(), points.place.end(), w);
      const bool is_axis = axis != points.place.end();
      out += w == 0 ? "" : " ";
      out += is_axis ? fmt::format("{}", x[axis - points.place.begin()]) : std::string(words[w]);
    }
    out += '\n';
  }
  return out.append(rest);
}

}  // namespace

size_t bytes_of_ply_type(const std::string& type) {
  static const std::map<std::string, size_t> kBytes = {
      {"char", 1},   {"int8", 1},    {"uchar", 1},  {"uint8", 1},  {"short", 2}, {"int16", 2},
      {"ushort", 2}, {"uint16", 2},  {"int", 4},    {"int32", 4},  {"uint", 4},  {"uint32", 4},
      {"float", 4},  {"float32", 4}, {"double", 8}, {"float64", 8}};
  const auto found = kBytes.find(type);
  return found == kBytes.end() ? 0 : found->second;
}

std::optional<PlyPoints> double_points(std::string_view ply) {
  constexpr size_t kLongestHeader = 1 << 16;
  if (!ply.starts_with("ply")) return std::nullopt;
  PlyHeader header;
  std::string_view rest = ply.substr(0, kLongestHeader);
  const size_t whole = rest.size();
  while (!rest.empty()) {
    const std::string line(next_line(rest));
    if (line != "end_header") {
      header.read(line);
      continue;
    }
    header.points.begin = whole - rest.size();
    if (!header.is_known || header.is_double != std::array{true, true, true}) return std::nullopt;
    return header.points;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector3d> far_middle(const PlyPoints& points, std::string_view ply) {
  Eigen::AlignedBox3d box;
  bool is_finite = true;
  const bool is_read = for_each_vertex(points, ply, [&](const Eigen::Vector3d& x) {
    is_finite = is_finite && x.allFinite();
    box.extend(x);
  });
  if (!is_read || !is_finite || box.isEmpty() || !(box.diagonal().norm() > 0)) return std::nullopt;
  if (box.center().norm() <= kFarSizes * box.diagonal().norm()) return std::nullopt;
  return Eigen::Vector3d(box.center().array().round());
}

std::string moved_ply(std::string_view ply, const PlyPoints& points, const Eigen::Vector3d& by) {
  if (points.format == PlyPoints::Format::kAscii) return moved_ascii(ply, points, by);
  std::string out(ply);
  for (size_t i = 0; i < points.count; ++i) {
    char* const vertex = out.data() + points.begin + i * points.stride;
    for (int axis = 0; axis < 3; ++axis) {
      char* const at = vertex + points.place[static_cast<size_t>(axis)];
      put_number(number_at(at, points.format) - by[axis], points.format, at);
    }
  }
  return out;
}

}  // namespace sightline
