// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/targets.h"

#include <cmath>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>

#include <sys/mman.h>
#include <unistd.h>

#include "eval/datasets/ply_reader.h"
#include "eval/doors/external_process.h"
#include "eval/doors/process_json.h"
#include "eval/output/csv_reader.h"
#include "eval/output/json.h"
#include "scenes/files/input_error.h"
#include "scenes/files/toml_table.h"
#include "scenes/mesh/mesh_soup.h"
#include "scenes/picture/picture_file.h"
#include "scenes/picture/radiance_file.h"

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

// What is refused by an InputError is refused well.
template <typename Get>
void attempt(const Get& get) {
  try {
    get();
  } catch (const InputError&) {
  }
}

// Bytes as a regular file that no disk has.
class BytesAsFile {
 public:
  explicit BytesAsFile(std::string_view bytes) : file_(memfd_create("fuzz", MFD_CLOEXEC)) {
    require(file_ >= 0);
    require(write(file_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  }
  ~BytesAsFile() { close(file_); }
  BytesAsFile(const BytesAsFile&) = delete;
  BytesAsFile& operator=(const BytesAsFile&) = delete;

  std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

void read_every_way(const TomlTable& table, const std::string& key) {
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

void fuzz_radiance(std::string_view bytes) {
  const PictureReading reading = decode_radiance(bytes);
  require(reading.pixels.empty() != reading.problem.empty());
  if (!reading.pixels.empty()) require(reading.pixels.type() == CV_32FC3);
}

void fuzz_json(std::string_view bytes) {
  const BytesAsFile file(bytes);
  try {
    const Json json = read_json(file.path());
    for (const char* key : {"0", "cam_K", "obj_id", "cells"}) {
      attempt([&] { whole_in(json, key); });
      attempt([&] { number_in(json, key); });
      attempt([&] { text_in(json, key); });
      attempt([&] { numbers_in(json, key, 9); });
      attempt([&] { numbers_or_nan_in(json, key, 3); });
    }
    for (const Json& value : json) attempt([&] { finite_numbers(value, "value", 3); });
  } catch (const InputError&) {
  }
}

void fuzz_csv(std::string_view bytes) {
  const BytesAsFile file(bytes);
  attempt([&] {
    CsvReader csv(file.path());
    while (csv.next()) {
      for (const std::string& column : csv.columns()) {
        attempt([&] { csv.whole(column); });
        attempt([&] { csv.integer(column); });
        attempt([&] { require(std::isfinite(csv.number(column))); });
        attempt([&] { csv.number_or(column, 0); });
        attempt([&] { require(csv.any_numbers(column, 3).size() == 3); });
        csv.names(column);
      }
    }
  });
}

void fuzz_model(std::string_view bytes) {
  const BytesAsFile file(bytes);
  attempt([&] {
    const Mesh mesh = read_ply_as_it_is(file.path());
    const int vertices = static_cast<int>(mesh.vertices.size());
    require(vertices > 0);
    for (const Triangle& triangle : mesh.triangles) {
      for (const int v : triangle.vertex) require(v >= 0 && v < vertices);
    }
  });
}

void fuzz_answer(std::string_view bytes) {
  const Json answer = Json::parse(bytes, nullptr, /*allow_exceptions=*/false);
  const auto attempt_answer = [](const auto& get) {
    try {
      get();
    } catch (const BadAnswer&) {
    } catch (const Json::exception&) {  // who asks a process takes both for a bad answer
    }
  };
  for (const char* key : {"pixel", "rotation", "covariance", "x"}) {
    attempt_answer([&] { require(std::isfinite(number_at(answer, key))); });
    attempt_answer([&] { require(vector_at(answer, key, 2).allFinite()); });
    attempt_answer([&] { require(square_matrix_at(answer, key, 3).allFinite()); });
    attempt_answer([&] { require(covariance_at(answer, key, 2).allFinite()); });
  }
}

}  // namespace sightline
