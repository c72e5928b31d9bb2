// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/ply_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <istream>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "eval/output/numbers.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"
#include "scenes/files/pauses.h"
#include "scenes/mesh/mesh_soup.h"
#include "scenes/mesh/ply_text.h"

namespace sightline {
namespace {

constexpr int kMostHeaderLines = 10'000;
constexpr uint64_t kMostCorners = 100'000;  // of a face
constexpr std::string_view kAxes = "xyz";

// How a number is written in a binary file.
struct PlyType {
  enum class Kind { kReal, kSigned, kUnsigned };
  Kind kind = Kind::kSigned;
  size_t bytes = 0;  // none of what is no type
};

PlyType ply_type(const std::string& name) {
  using Kind = PlyType::Kind;
  const bool is_real = name.starts_with('f') || name.starts_with('d');
  const Kind whole = name.starts_with('u') ? Kind::kUnsigned : Kind::kSigned;
  return {is_real ? Kind::kReal : whole, bytes_of_ply_type(name)};
}

struct PlyProperty {
  PlyType type;
  std::optional<PlyType> count{};      // of a list
  std::optional<Eigen::Index> axis{};  // of x, y and z
  bool has_corners = false;

  bool is_known() const { return type.bytes > 0 && (!count || count->bytes > 0); }
};

PlyProperty ply_list(const std::string& name, PlyType count, PlyType type) {
  return {.type = type,
          .count = count,
          .has_corners = name == "vertex_indices" || name == "vertex_index"};
}

PlyProperty ply_number(const std::string& name, PlyType type) {
  PlyProperty property{.type = type};
  if (name.size() == 1 && kAxes.find(name) != kAxes.npos) {
    property.axis = static_cast<Eigen::Index>(kAxes.find(name));
  }
  return property;
}

struct PlyElement {
  std::string name;
  uint64_t rows = 0;
  std::vector<PlyProperty> properties;

  bool is_of_vertices() const { return name == "vertex" || name == "vertices"; }
  bool is_of_faces() const { return name == "face" || name == "faces"; }
};

// A number of a binary file from its bytes as memory has them.
double number_from(const std::array<char, 8>& bytes, PlyType type) {
  uint64_t bits = 0;
  std::memcpy(&bits, bytes.data(), type.bytes);
  const size_t unused = 64 - 8 * type.bytes;
  switch (type.kind) {
    case PlyType::Kind::kReal:
      return type.bytes == 8 ? std::bit_cast<double>(bits)
                             : std::bit_cast<float>(static_cast<uint32_t>(bits));
    case PlyType::Kind::kUnsigned:
      return static_cast<double>(bits);
    case PlyType::Kind::kSigned:
      break;
  }
  return static_cast<double>(static_cast<int64_t>(bits << unused) >> unused);
}

class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& file)
      : file_(file), stream_(open_input_file(file, kMostModelBytes)) {
    mesh_.parts.push_back({.name = file.stem().string()});
  }

  Mesh read() {
    read_header();
    for (const PlyElement& element : elements_) read_rows(element);
    if (mesh_.vertices.empty()) fail("has no vertices");
    mesh_.triangles.resize(triangles_.size());
    for (size_t i = 0; i < triangles_.size(); ++i) mesh_.triangles[i].vertex = triangles_[i];
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(fmt::format("{}: {}", file_.string(), reason));
  }

  // ---- the header

  // A line of the header, which ends as those of a text may. Where the first line ends with CR
  // alone so does the last, and an LF behind it is a binary file's first byte.
  bool read_header_line(bool is_first) {
    line_.clear();
    std::streambuf& bytes = *stream_->rdbuf();
    constexpr int kEnd = std::char_traits<char>::eof();
    int next = bytes.sbumpc();
    for (; next != kEnd && next != '\n' && next != '\r'; next = bytes.sbumpc()) {
      if (line_.size() == kLongestLine) return true;
      line_ += static_cast<char>(next);
    }
    if (next != '\r') return next == '\n' || !line_.empty();
    const bool has_both = bytes.sgetc() == '\n';
    if (is_first) ends_with_cr_ = !has_both;
    if (has_both && !ends_with_cr_) bytes.sbumpc();
    return true;
  }

  std::vector<std::string> header_words(bool is_first = false) {
    if (!read_header_line(is_first)) fail("cannot be read as a PLY mesh: its header does not end");
    std::istringstream stream(line_.substr(0, kShownOfLine));
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    return words;
  }

  void read_header() {
    if (header_words(/*is_first=*/true) != std::vector<std::string>{"ply"}) {
      fail("cannot be read as a PLY mesh: its first line must be 'ply'");
    }
    for (int lines = 0; lines < kMostHeaderLines; ++lines) {
      const std::vector<std::string> words = header_words();
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") return check_header();
      if (!is_taken(words)) {
        fail(fmt::format("cannot be read as a PLY mesh: its header has the line '{}'",
                         line_.substr(0, 60)));
      }
    }
    fail(fmt::format("cannot be read as a PLY mesh: its header does not end in {} lines",
                     kMostHeaderLines));
  }

  // Whether a line of the header is as it must be.
  bool is_taken(const std::vector<std::string>& words) {
    if (words.size() < 3) return false;
    if (words[0] == "format") {
      has_format_ = true;
      is_text_ = words[1] == "ascii";
      is_big_endian_ = words[1] == "binary_big_endian";
      return is_text_ || is_big_endian_ || words[1] == "binary_little_endian";
    }
    if (words[0] == "element") {
      elements_.push_back({.name = words[1], .properties = {}});
      const char* const end = words[2].data() + words[2].size();
      const auto [rest, error] = std::from_chars(words[2].data(), end, elements_.back().rows);
      return error == std::errc() && rest == end;
    }
    if (words[0] != "property" || elements_.empty()) return false;
    const bool is_list = words[1] == "list";
    if (words.size() < (is_list ? 5u : 3u)) return false;
    elements_.back().properties.push_back(
        is_list ? ply_list(words[4], ply_type(words[2]), ply_type(words[3]))
                : ply_number(words[2], ply_type(words[1])));
    return elements_.back().properties.back().is_known();
  }

  void check_header() {
    if (!has_format_) fail("cannot be read as a PLY mesh: its header states no format");
    for (const PlyElement& element : elements_) {
      if (!element.is_of_vertices()) continue;
      std::array<int, 3> times{};
      for (const PlyProperty& property : element.properties) {
        if (property.axis) ++times[static_cast<size_t>(*property.axis)];
      }
      if (times != std::array{1, 1, 1}) fail("its vertices must have each of x, y and z once");
      vertices_ += static_cast<double>(element.rows);
    }
  }

  // ---- the rows

  void read_rows(const PlyElement& element) {
    if (element.properties.empty()) return;  // however many there are, they take no bytes
    std::vector<int> corners;
    for (uint64_t row = 0; row < element.rows; ++row) {
      pause_at_times();
      begin_row(element);
      Eigen::Vector3d place;
      for (const PlyProperty& property : element.properties) {
        if (property.count) {
          read_list(element, property, corners);
        } else if (property.axis && element.is_of_vertices()) {
          place[*property.axis] = next_number(element, property.type);
        } else {
          skip_number(element, property.type);
        }
      }
      if (element.is_of_vertices()) add_vertex(place);
      if (element.is_of_faces()) add_face(corners);
    }
  }

  // What another list than a face's corners holds is forgotten.
  void read_list(const PlyElement& element, const PlyProperty& property,
                 std::vector<int>& corners) {
    const double count = next_number(element, *property.count);
    if (!(count >= 0) || count != std::floor(count)) {
      fail(fmt::format("a row of '{}' has a list of {} numbers", element.name, count));
    }
    if (property.has_corners && element.is_of_faces()) {
      if (count > kMostCorners) {
        fail(fmt::format("a face has {} corners; at most {} are read", count, kMostCorners));
      }
      corners.clear();
      for (double i = 0; i < count; ++i) {
        corners.push_back(vertex_of(next_number(element, property.type)));
      }
    } else {
      for (double i = 0; i < count; ++i) skip_number(element, property.type);
    }
  }

  // In a text each row is a line, behind whose numbers may stand what the header does not tell of.
  void begin_row(const PlyElement& element) {
    if (!is_text_) return;
    do {
      if (!read_bounded_line(*stream_, line_)) fail_as_cut_short(element);
      if (line_.size() > kLongestLine)
        fail(fmt::format("has a line of over {} bytes", kLongestLine));
      rest_ = line_;
      skip_blanks();
    } while (rest_.empty());
  }

  void skip_blanks() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
  }

  double next_number(const PlyElement& element, PlyType type) {
    return is_text_ ? next_of_line(element) : next_of_bytes(element, type);
  }

  // What is not used need be no number: old compilers' programs write normals of "-1.#IND".
  void skip_number(const PlyElement& element, PlyType type) {
    if (is_text_) {
      next_word(element);
    } else {
      next_of_bytes(element, type);
    }
  }

  std::string_view next_word(const PlyElement& element) {
    const std::string_view word = rest_.substr(0, rest_.find_first_of(kBlanks));
    if (word.empty()) fail_at_word(element, "its end");
    rest_.remove_prefix(word.size());
    skip_blanks();
    return word;
  }

  double next_of_line(const PlyElement& element) {
    const std::string_view word = next_word(element);
    const auto number = parsed_number(word);
    if (!number) fail_at_word(element, fmt::format("'{}'", word.substr(0, 40)));
    return *number;
  }

  [[noreturn]] void fail_at_word(const PlyElement& element, const std::string& word) const {
    fail(fmt::format("a row of '{}' has {} where a number must stand", element.name, word));
  }

  double next_of_bytes(const PlyElement& element, PlyType type) {
    static_assert(std::endian::native == std::endian::little,
                  "numbers are read as memory has them");
    std::array<char, 8> bytes{};
    const auto size = static_cast<std::streamsize>(type.bytes);
    if (stream_->rdbuf()->sgetn(bytes.data(), size) != size) fail_as_cut_short(element);
    if (is_big_endian_) std::reverse(bytes.begin(), bytes.begin() + size);
    return number_from(bytes, type);
  }

  [[noreturn]] void fail_as_cut_short(const PlyElement& element) const {
    fail(fmt::format("is cut short: it ends within its {} rows of '{}'", element.rows,
                     element.name));
  }

  // ---- what they tell

  void add_vertex(const Eigen::Vector3d& place) {
    if (!place.allFinite()) fail("a vertex is not a finite number");
    mesh_.vertices.push_back(place);
  }

  int vertex_of(double corner) const {
    const double end = std::min<double>(vertices_, std::numeric_limits<int>::max());
    if (corner >= 0 && corner < end && corner == std::floor(corner)) {
      return static_cast<int>(corner);
    }
    fail("a face has a vertex that is not there");
  }

  void add_face(const std::vector<int>& corners) {
    if (triangles_.size() + corners.size() > kMaxTriangles + 2) {
      fail(fmt::format("has more than {} triangles", kMaxTriangles));
    }
    for (size_t i = 2; i < corners.size(); ++i) {
      triangles_.push_back({corners[0], corners[i - 1], corners[i]});
    }
  }

  static constexpr std::string_view kBlanks = " \t";
  static constexpr size_t kShownOfLine = 1000;  // of a header's, which are short

  std::filesystem::path file_;
  std::unique_ptr<std::istream> stream_;
  bool has_format_ = false;
  bool is_text_ = false;
  bool is_big_endian_ = false;
  bool ends_with_cr_ = false;  // each line, as the first
  double vertices_ = 0;        // that the header tells of
  std::vector<PlyElement> elements_;
  std::string line_;
  std::string_view rest_;                      // of it
  std::vector<std::array<int, 3>> triangles_;  // a mesh's take seven times the memory
  Mesh mesh_;
};

}  // namespace

Mesh read_ply_as_it_is(const std::filesystem::path& file) {
  return PlyReader(file).read();
}

}  // namespace sightline
