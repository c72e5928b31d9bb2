// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/ply_reader.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// The bytes of a number of a type in a format; of a text, its digits.
template <typename Number>
std::string bytes_of(double value, const std::string& format) {
  if (format == "ascii") return fmt::format("{} ", value);
  const auto number = static_cast<Number>(value);
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  if (format == "binary_big_endian") std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

class PlyOfPoints : public testing::Test {
 protected:
  // Of vertices with the places 1 2 3, 4 5 6 and 7 8 -9 (9 where the type has no sign), and a face
  // of them all.
  template <typename Number>
  void expect_read(const std::string& type, const std::string& format) {
    const double last = std::is_unsigned_v<Number> ? 9 : -9;
    std::string ply = fmt::format(
        "ply\nformat {} 1.0\nelement vertex 3\nproperty {} x\nproperty {} y\nproperty {} z\n"
        "element face 1\nproperty list uchar {} vertex_indices\nend_header\n",
        format, type, type, type, type);
    const std::string end = format == "ascii" ? "\n" : "";
    for (const std::array<double, 3>& row :
         {std::array<double, 3>{1, 2, 3}, {4, 5, 6}, {7, 8, last}}) {
      for (const double value : row) ply += bytes_of<Number>(value, format);
      ply += end;
    }
    ply += bytes_of<uint8_t>(3, format);
    for (const double corner : {2, 0, 1}) ply += bytes_of<Number>(corner, format);
    const Mesh mesh = read(ply + end);
    ASSERT_EQ(mesh.vertices.size(), 3u) << type << " " << format;
    EXPECT_EQ(mesh.vertices[2], Eigen::Vector3d(7, 8, last)) << type << " " << format;
    ASSERT_EQ(mesh.triangles.size(), 1u);
    EXPECT_EQ(mesh.triangles[0].vertex, (std::array{2, 0, 1}));
  }

  Mesh read(const std::string& ply) const { return read_ply_as_it_is(folder_.write("m.ply", ply)); }
  std::string error(const std::string& ply) const {
    return error_of([&] { read(ply); });
  }

  TemporaryFolder folder_;
};

TEST_F(PlyOfPoints, HasNumbersOfAnyTypeInAnyFormat) {
  for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const char* type : {"char", "int8"}) expect_read<int8_t>(type, format);
    for (const char* type : {"uchar", "uint8"}) expect_read<uint8_t>(type, format);
    for (const char* type : {"short", "int16"}) expect_read<int16_t>(type, format);
    for (const char* type : {"ushort", "uint16"}) expect_read<uint16_t>(type, format);
    for (const char* type : {"int", "int32"}) expect_read<int32_t>(type, format);
    for (const char* type : {"uint", "uint32"}) expect_read<uint32_t>(type, format);
    for (const char* type : {"float", "float32"}) expect_read<float>(type, format);
    for (const char* type : {"double", "float64"}) expect_read<double>(type, format);
  }
}

const std::string kHead = "ply\nformat ascii 1.0\n";
const std::string kVertices =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kFaces = "element face 2\nproperty list uchar int vertex_index\n";
const std::string kEnd = "end_header\n";
const std::string kPlaces = "0 0 0\n1 0 0\n1 1 0\n0 1 2.5\n";
const std::string kCorners = "3 0 1 2\n3 0 2 3\n";

TEST_F(PlyOfPoints, IsReadAsItStandsBesideWhatIsNoVertexAndNoFace) {
  const std::string plain = kHead + kVertices + kFaces + kEnd + kPlaces + kCorners;
  const auto replaced = [&plain](const std::string& what, const std::string& by) {
    std::string text = plain;
    for (size_t at = text.find(what); at != text.npos; at = text.find(what, at + by.size())) {
      text.replace(at, what.size(), by);
    }
    return text;
  };
  const std::string with_more =
      "element vertex 4\nproperty list uchar int near\n"
      "property float z\nproperty double x\nproperty uchar red\n"
      "property float y\nproperty float quality\n";
  for (const std::string& text :
       {plain, replaced("\n", "\r\n"), replaced("\n", "\r"), replaced("\n", "\n\n"),
        replaced(" ", "  "), replaced("end_header", "comment\nobj_info by hand\nend_header"),
        replaced("0 0\n", "0.0e+00 +0 \n"), replaced("0 0\n", "0 0 17 18\n"),
        // One face of four corners and one of two.
        kHead + kVertices + kFaces + kEnd + kPlaces + "4 0 1 2 3\n2 0 1\n",
        kHead + kFaces + kVertices + kEnd + kCorners + kPlaces,
        kHead + "element camera 1\nproperty float f\nelement nothing 99999999999999\n" + kVertices +
            kFaces + kEnd + "500\n" + kPlaces + kCorners,
        kHead + kVertices + kFaces + "element edge 1\nproperty int a\nproperty int b\n" + kEnd +
            kPlaces + kCorners + "0 1\n",
        kHead + kVertices +
            "element face 2\nproperty uchar red\nproperty list uchar int "
            "vertex_indices\nproperty list uchar float texcoord\n" +
            kEnd + kPlaces + "9 3 0 1 2 6 0 0 0 0 0 0\n9 3 0 2 3 1 0.5\n",
        kHead + with_more + kFaces + kEnd +
            "0 0 0 255 0 nan\n2 3 4 0 1 255 0 inf\n0 0 1 255 1 -1\n0 2.5 0 255 1 0\n" + kCorners}) {
    const Mesh mesh = read(text);
    ASSERT_EQ(mesh.vertices.size(), 4u) << text;
    EXPECT_EQ(mesh.vertices[1], Eigen::Vector3d(1, 0, 0)) << text;
    EXPECT_EQ(mesh.vertices[3], Eigen::Vector3d(0, 1, 2.5)) << text;
    ASSERT_EQ(mesh.triangles.size(), 2u) << text;
    EXPECT_EQ(mesh.triangles[1].vertex, (std::array{0, 2, 3})) << text;
  }
  EXPECT_TRUE(read(kHead + kVertices + kEnd + kPlaces).triangles.empty());
}

TEST_F(PlyOfPoints, NeedsNumbersOnlyWhereItUsesThem) {
  const Mesh mesh =
      read(kHead + "element vertex 1\nproperty float x\nproperty float nx\nproperty float y\n" +
           "property list uchar float near\nproperty float z\nelement camera 1\n" +
           "property float x\n" + kEnd + "1 -1.#IND -1e-400 2 1.#INF n/a 3\nnone\n");
  ASSERT_EQ(mesh.vertices.size(), 1u);
  EXPECT_EQ(mesh.vertices[0], Eigen::Vector3d(1, 0, 3));
}

// The first byte is that of an LF.
TEST_F(PlyOfPoints, BeginBehindTheEndOfTheHeaderAsItsLinesEnd) {
  for (const std::string end : {"\n", "\r", "\r\n"}) {
    std::string ply = "ply\nformat binary_little_endian 1.0\n";
    ply += "element vertex 1\nproperty uchar x\nproperty uchar y\nproperty uchar z\nend_header\n";
    for (size_t at = ply.find('\n'); at != ply.npos; at = ply.find('\n', at + end.size())) {
      ply.replace(at, 1, end);
    }
    const Mesh mesh = read(ply + "\n\r\n");
    ASSERT_EQ(mesh.vertices.size(), 1u);
    EXPECT_EQ(mesh.vertices[0], Eigen::Vector3d(10, 13, 10)) << testing::PrintToString(end);
  }
}

// They pack to next to nothing, and a triangle takes many times a corner's bytes.
TEST_F(PlyOfPoints, OfFacesWithoutEndAreRefused) {
  const std::string head =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\n"
      "property uchar y\nproperty uchar z\nelement face 200\n"
      "property list uint uchar vertex_index\nend_header\n";
  const std::string vertex(3, '\0');
  const auto face = [](uint32_t corners) {
    return bytes_of<uint32_t>(corners, "binary_little_endian") + std::string(corners, '\0');
  };
  EXPECT_THAT(error(head + vertex + face(100'001)),
              HasSubstr("m.ply: a face has 100001 corners; at most 100000 are read"));
  std::string faces;
  for (int i = 0; i < 120; ++i) faces += face(100'000);
  EXPECT_THAT(error(head + vertex + faces), HasSubstr("is cut short"));
  EXPECT_THAT(error(head + vertex + faces + face(300)),
              HasSubstr("m.ply: has more than 12000000 triangles"));
}

TEST_F(PlyOfPoints, ThatIsNoneIsSaidInOneLine) {
  const std::string head = kHead + kVertices + kFaces + kEnd;
  const std::string binary = "ply\nformat binary_little_endian 1.0\n" + kVertices + kEnd;
  const auto without = [&](const std::string& line) {
    std::string text = head + kPlaces + kCorners;
    return text.erase(text.find(line), line.size());
  };
  const std::array<std::array<std::string, 2>, 17> cases = {{
      {"solid cube\n", "cannot be read as a PLY mesh: its first line must be 'ply'"},
      {"", "cannot be read as a PLY mesh: its header does not end"},
      {kHead + kVertices, "its header does not end"},
      {without("format ascii 1.0\n"), "its header states no format"},
      {"ply\nformat utf8 1.0\n" + kEnd, "its header has the line 'format utf8 1.0'"},
      {kHead + "element vertex -3\n" + kEnd, "its header has the line 'element vertex -3'"},
      {kHead + "element vertex 99999999999999999999\n" + kEnd,
       "its header has the line 'element vertex 99999999999999999999'"},
      {kHead + kVertices + "element face 99999999999999999999\n" + kEnd,
       "its header has the line 'element face 99999999999999999999'"},
      {head + "0 0 1e400\n", "a row of 'vertex' has '1e400' where a number must stand"},
      {kHead + "element vertex 3\nproperty half x\n" + kEnd, "has the line 'property half x'"},
      {without("property float y\n"), "its vertices must have each of x, y and z once"},
      {kHead + kEnd, "has no vertices"},
      {head + "0 0 0\n1 0\n", "a row of 'vertex' has its end where a number must stand"},
      {head + "0 0 zero\n", "a row of 'vertex' has 'zero' where a number must stand"},
      {head + kPlaces + "3 0 1 2\n", "is cut short: it ends within its 2 rows of 'face'"},
      {binary + std::string(47, '\0'), "is cut short: it ends within its 4 rows of 'vertex'"},
      {head + kPlaces + "3 0 1 2\n3 0 1 4\n", "a face has a vertex that is not there"},
  }};
  for (const auto& [ply, words] : cases) {
    EXPECT_THAT(error(ply), HasSubstr("m.ply: "));
    EXPECT_THAT(error(ply), HasSubstr(words));
  }
  for (const char* corner : {"-1", "1.5", "nan", "1e300"}) {
    EXPECT_THAT(error(head + kPlaces + "3 0 1 2\n3 0 1 " + corner + "\n"),
                HasSubstr("a face has a vertex that is not there"));
  }
  EXPECT_THAT(error(head + kPlaces + "3 0 1 2\n-3 0 1 2\n"), HasSubstr("has a list of -3 numbers"));
  EXPECT_THAT(error(head + "0 0 inf\n" + kPlaces), HasSubstr("a vertex is not a finite number"));
}

}  // namespace
}  // namespace sightline
