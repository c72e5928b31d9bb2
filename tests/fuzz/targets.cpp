// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/targets.h"

#include <cstdlib>
#include <exception>
#include <string>

#include "scenes/files/input_error.h"
#include "scenes/files/toml_table.h"
#include "scenes/mesh/mesh_soup.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

const std::filesystem::path kFile = "fuzz/input";

void require(bool condition) {
  if (!condition) std::abort();
}

void require_whole(const Mesh& mesh) {
  const int vertices = static_cast<int>(mesh.vertices.size());
  const int parts = static_cast<int>(mesh.parts.size());
  require(!mesh.triangles.empty());
  for (const Eigen::Vector3d& vertex : mesh.vertices) require(vertex.allFinite());
  for (const Triangle& triangle : mesh.triangles) {
    require(triangle.part >= 0 && triangle.part < parts);
    for (const int v : triangle.vertex) require(v >= 0 && v < vertices);
    for (const Eigen::Vector3d& normal : triangle.normal) require(normal.norm() < 1 + 1e-5);
  }
}

void read_every_way(const TomlTable& table, const std::string& key) {
  const auto attempt = [](const auto& get) {
    try {
      get();
    } catch (const InputError&) {
    }
  };
  attempt([&] { table.number(key, {-1, 1}); });
  attempt([&] { table.integer(key); });
  attempt([&] { table.flag(key); });
  attempt([&] { table.text(key); });
  attempt([&] { table.choice(key, std::vector<std::string>{"a", "b"}); });
  attempt([&] { table.texts(key); });
  attempt([&] { table.numbers(key, 2); });
  attempt([&] { table.number_list(key, {}); });
  attempt([&] { table.vector3(key); });
  attempt([&] { table.point_lists(key, 2, 2); });
  attempt([&] { table.table(key).number(key); });
  attempt([&] { table.tables(key); });
}

}  // namespace

void fuzz_soup(std::string_view bytes) {
  try {
    const MeshSoup soup = decode(bytes, kFile);
    require(encode(decode(encode(soup), kFile)) == encode(soup));
    require_whole(clean(soup, {}, kFile).mesh);
  } catch (const InputError&) {
  }
}

void fuzz_gltf(std::string_view bytes) {
  try {
    const MeshSoup soup = read_gltf_bytes(bytes, kFile);
    require(soup.triangles.size() <= kMaxTriangles && soup.parts.size() <= kMaxParts);
    decode(encode(soup), kFile);
  } catch (const std::exception&) {  // the reader's process makes one line of any
  }
}

void fuzz_toml(std::string_view bytes) {
  try {
    const TomlTable table = TomlTable::read_text(std::string(bytes), kFile, {});
    for (const char* key : {"a", "name", "feature", "mesh", "position_m"}) {
      read_every_way(table, key);
    }
    TomlTable::read_text(table.to_toml(), kFile, {});  // as written it reads again
    table.reject_unknown_keys();
  } catch (const InputError&) {
  }
}

void fuzz_picture(std::string_view bytes) {
  for (const PictureChannels channels : {PictureChannels::kAsStored, PictureChannels::kGrey}) {
    const PictureReading reading = decode_picture(bytes, channels);
    require(reading.pixels.empty() != reading.problem.empty());
    const int64_t pixels = int64_t{reading.pixels.rows} * reading.pixels.cols;
    require(pixels <= kMaxPicturePixels);
    if (channels == PictureChannels::kGrey && pixels > 0) require(reading.pixels.type() == CV_8UC1);
  }
}

}  // namespace sightline
