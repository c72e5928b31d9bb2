// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh_text.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zlib.h>

namespace sightline {
namespace {

constexpr const char* kCadAdvice =
    "a CAD model of curved surfaces, no mesh; let a CAD program (FreeCAD: File, Export) write it "
    "as .glb, .stl or .obj";
constexpr const char* kUsdAdvice =
    "a USD scene, which is not read here; let Blender (File, Export, glTF) write it as .glb";
constexpr const char* kRobotAdvice =
    "a robot's description, which names its meshes; give one of those (<mesh filename=...>)";

// Files that people take for meshes.
struct NoMesh {
  const char* extension;  // with its dot; or none
  const char* beginning;  // of the file; or none
  const char* what;
};
constexpr NoMesh kNoMeshes[] = {
    {".step", "", kCadAdvice},
    {".stp", "", kCadAdvice},
    {".iges", "", kCadAdvice},
    {".igs", "", kCadAdvice},
    {".brep", "", kCadAdvice},
    {".fcstd", "", kCadAdvice},
    {".sldprt", "", kCadAdvice},
    {".usd", "#usda", kUsdAdvice},
    {".usda", "PXR-USDC", kUsdAdvice},
    {".usdc", "", kUsdAdvice},
    {".usdz", "", kUsdAdvice},
    {".urdf", "<robot", kRobotAdvice},
    {".xacro", "", kRobotAdvice},
    {".sdf", "<sdf", kRobotAdvice},
    {".mtl", "", "the materials of an .obj; give that"},
    {".bin", "", "the buffer of a .gltf; give that"},
};

bool is_space(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0;
}

char lower(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

std::string lowered(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), lower);
  return out;
}

// A file of ISO 10303-21, which Assimp reads where it is a building (IFC) and not a part.
bool is_step_part(std::string_view beginning) {
  return beginning.starts_with("ISO-10303-21") &&
         beginning.find("FILE_SCHEMA") != std::string_view::npos &&
         beginning.find("IFC") == std::string_view::npos;
}

// The value of an attribute of the first element of that name; empty where there is none.
std::string_view attribute_of(std::string_view text, std::string_view element,
                              std::string_view attribute) {
  const size_t at = text.find(element);
  if (at == std::string_view::npos) return {};
  std::string_view inside = text.substr(at, text.find('>', at) - at);
  const size_t name = inside.find(fmt::format(" {}=", attribute));
  if (name == std::string_view::npos) return {};
  inside.remove_prefix(name);
  const size_t open = inside.find_first_of("\"'");
  if (open == std::string_view::npos) return {};
  const size_t close = inside.find(inside[open], open + 1);
  return close == std::string_view::npos ? std::string_view{}
                                         : inside.substr(open + 1, close - open - 1);
}

constexpr size_t kBeginningBytes = 4000;

// The first bytes of what "deflate" has packed, as far as they can be unpacked.
std::string inflated_beginning(std::string_view packed) {
  std::string out(kBeginningBytes, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return "";
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));  // it only reads
  stream.avail_in = static_cast<uInt>(std::min(packed.size(), 16 * kBeginningBytes));
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  inflate(&stream, Z_SYNC_FLUSH);
  out.resize(out.size() - stream.avail_out);
  inflateEnd(&stream);
  return out;
}

}  // namespace

std::string lower_extension(const std::filesystem::path& file) {
  return lowered(file.extension().string());
}

std::string why_no_mesh(const std::filesystem::path& file, std::string_view beginning) {
  while (!beginning.empty() && is_space(beginning.front())) beginning.remove_prefix(1);
  if (is_step_part(beginning)) return kCadAdvice;
  const std::string extension = lower_extension(file);
  for (const NoMesh& known : kNoMeshes) {
    const std::string_view begins(known.beginning);
    const bool is_known =
        extension == known.extension || (!begins.empty() && beginning.starts_with(begins));
    if (is_known) return known.what;
  }
  return "";
}

double collada_unit_m(std::string_view text) {
  const std::string_view value = attribute_of(text, "<unit", "meter");
  double metres = 1;
  std::from_chars(value.data(), value.data() + value.size(), metres);
  return metres > 0 && std::isfinite(metres) ? metres : 1;
}

double threemf_unit_m(std::string_view text) {
  const std::string_view unit = attribute_of(text, "<model", "unit");
  if (unit == "micron") return 1e-6;
  if (unit == "centimeter") return 0.01;
  if (unit == "inch") return 0.0254;
  if (unit == "foot") return 0.3048;
  return unit == "meter" ? 1 : 0.001;
}

std::string beginning_in_zip(std::string_view archive, std::string_view ending) {
  // A local file header (PKWARE's APPNOTE 6.3.10, 4.3.7): 30 bytes, the name, an extra field.
  constexpr std::string_view kLocalHeader("PK\3\4", 4);
  constexpr size_t kHeaderBytes = 30;
  const auto number = [&archive](size_t at) {
    uint16_t value = 0;
    std::memcpy(&value, archive.data() + at, sizeof value);
    return value;
  };
  for (size_t at = archive.find(kLocalHeader); at != std::string_view::npos;
       at = archive.find(kLocalHeader, at + 1)) {
    if (archive.size() - at < kHeaderBytes) break;
    const size_t name_bytes = number(at + 26);
    const size_t begin = at + kHeaderBytes + name_bytes + number(at + 28);
    if (begin > archive.size()) continue;
    if (!archive.substr(at + kHeaderBytes, name_bytes).ends_with(ending)) continue;
    const std::string_view packed = archive.substr(begin);
    const int method = number(at + 8);
    if (method == 0) return std::string(packed.substr(0, kBeginningBytes));
    return method == 8 ? inflated_beginning(packed) : "";
  }
  return "";
}

std::string listed(const std::set<std::string>& names) {
  constexpr size_t kMost = 5;
  const auto count = static_cast<std::ptrdiff_t>(std::min(kMost, names.size()));
  const std::string text =
      fmt::format("{}", fmt::join(names.begin(), std::next(names.begin(), count), ", "));
  return names.size() <= kMost ? text : fmt::format("{} and {} more", text, names.size() - kMost);
}

std::string tidy_stl(std::string_view bytes) {
  constexpr size_t kHeaderBytes = 84;  // a comment of 80, and the number of triangles
  constexpr size_t kTriangleBytes = 50;
  size_t blank = 0;
  while (blank < bytes.size() && is_space(bytes[blank])) ++blank;
  const std::string word = lowered(bytes.substr(blank, 5));
  uint32_t count = 0;
  if (bytes.size() >= kHeaderBytes) std::memcpy(&count, bytes.data() + 80, sizeof count);
  const size_t whole = kHeaderBytes + kTriangleBytes * count;
  if (bytes.size() == whole) return "";
  if (word != "solid") {
    const bool has_more = bytes.size() > whole && count > 0;
    return has_more ? std::string(bytes.substr(0, whole)) : "";
  }
  const bool is_tidy = blank == 0 && bytes.starts_with("solid") &&
                       bytes.find("FACET") == std::string_view::npos &&
                       bytes.find("Facet") == std::string_view::npos;
  return is_tidy ? "" : lowered(bytes.substr(blank));
}

}  // namespace sightline
