// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/mesh_use.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <fnmatch.h>

#include "scenes/files/input_error.h"
#include "scenes/mesh/mesh_inspection.h"

namespace sightline {
namespace {

std::vector<bool> fitting_parts(const std::string& pattern, const Mesh& mesh) {
  std::vector<bool> fits;
  for (const Part& part : mesh.parts) {
    fits.push_back(part.name == pattern || fnmatch(pattern.c_str(), part.name.c_str(), 0) == 0);
  }
  return fits;
}

// Drops the vertices that no triangle has.
void compact_vertices(Mesh& mesh) {
  std::vector<int> place(mesh.vertices.size(), -1);
  std::vector<Eigen::Vector3d> kept;
  for (Triangle& triangle : mesh.triangles) {
    for (int& vertex : triangle.vertex) {
      if (place[vertex] < 0) {
        place[vertex] = static_cast<int>(kept.size());
        kept.push_back(mesh.vertices[vertex]);
      }
      vertex = place[vertex];
    }
  }
  mesh.vertices = std::move(kept);
}

Mesh one_sided_only(const Mesh& mesh) {
  Mesh part{.vertices = mesh.vertices, .triangles = {}, .parts = mesh.parts};
  const std::vector<bool> one_sided = one_sided_parts(mesh);
  std::copy_if(mesh.triangles.begin(), mesh.triangles.end(), std::back_inserter(part.triangles),
               [&](const Triangle& triangle) { return one_sided[triangle.part]; });
  return part;
}

// Whether a triangle lies back to back with its neighbour, as those of a sheet's two sides do.
bool has_flat_fold(const Mesh& mesh) {
  constexpr double kFlat = 1e-8;  // 1 + the cosine between the normals
  const std::vector<HalfEdge> halves = sorted_half_edges(mesh);
  return std::adjacent_find(
             halves.begin(), halves.end(), [&](const HalfEdge& a, const HalfEdge& b) {
               if (a.low != b.low || a.high != b.high) return false;
               const Eigen::Vector3d one = face_normal(mesh, mesh.triangles[a.triangle]);
               return one.dot(face_normal(mesh, mesh.triangles[b.triangle])) < kFlat - 1;
             }) != halves.end();
}

void make_two_sided(Mesh& mesh) {
  for (Part& part : mesh.parts) {
    if (part.material) part.material->is_two_sided = true;
  }
}

}  // namespace

MeshFrame frame_of(const MeshUse& use) {
  MeshFrame frame;
  if (!use.forward.empty()) frame.forward = use.forward;
  if (!use.up.empty()) frame.up = use.up;
  if (!use.unit.empty()) frame.unit_m = unit_named(use.unit);
  return frame;
}

void hide_parts(const std::vector<std::string>& hidden, const std::filesystem::path& file,
                Mesh& mesh) {
  if (hidden.empty()) return;
  std::vector<std::string> names;
  for (const Part& part : mesh.parts) names.push_back(part.name);
  std::vector<bool> is_hidden(mesh.parts.size(), false);
  for (const std::string& pattern : hidden) {
    const std::vector<bool> fits = fitting_parts(pattern, mesh);
    if (std::find(fits.begin(), fits.end(), true) == fits.end()) {
      throw InputError(fmt::format("{}: has no part \"{}\" to hide{}", file.string(), pattern,
                                   suggestion(pattern, names)));
    }
    for (size_t i = 0; i < fits.size(); ++i) is_hidden[i] = is_hidden[i] || fits[i];
  }
  size_t kept = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (is_hidden[mesh.triangles[i].part]) continue;
    mesh.triangles[kept] = mesh.triangles[i];
    if (!mesh.coats.empty()) mesh.coats[kept] = mesh.coats[i];
    ++kept;
  }
  if (kept == 0) throw InputError(fmt::format("{}: all its parts are hidden", file.string()));
  mesh.triangles.resize(kept);
  if (!mesh.coats.empty()) mesh.coats.resize(kept);
  compact_vertices(mesh);
}

std::string take_backfaces(const MeshUse& use, Mesh& mesh) {
  if (use.backfaces == "seen") {
    make_two_sided(mesh);
    return "";
  }
  if (!use.backfaces.empty() && use.backfaces != "material") {
    throw InputError(
        fmt::format("mesh.backfaces: is \"{}\", must be \"material\" or \"seen\"", use.backfaces));
  }
  if (one_sided_parts(mesh).empty()) return "";
  const std::string what =
      "its one-sided surfaces (glTF without doubleSided) are not drawn from behind";
  const std::string remedy = "--backfaces seen (mesh.backfaces) draws their backs too";
  constexpr size_t kMostInspected = 1'000'000;  // triangles; more take memory and time
  if (mesh.triangles.size() > kMostInspected) return what + "; " + remedy;
  const Mesh one_sided = one_sided_only(mesh);
  const MeshInspection found = inspect(one_sided);
  if (found.open_edges + found.flipped_edges + found.inward_components == 0) {
    // Nobody sees a back of it from outside, unless it lies on its front.
    if (!has_flat_fold(one_sided)) make_two_sided(mesh);
    return "";
  }
  return fmt::format(
      "{}, and have {} open edges, {} edges whose faces disagree and {} closed pieces inside out; "
      "{}",
      what, found.open_edges, found.flipped_edges, found.inward_components, remedy);
}

std::string taken_note(const MeshUse& use, bool is_mesh_file) {
  std::string note;
  if (is_mesh_file) {
    const MeshFrame frame = frame_of(use);
    note = fmt::format("taken in {}, with {} forward and {} up (--unit, --forward, --up)",
                       use.unit.empty() ? "metres, or the unit that it states" : use.unit,
                       frame.forward, frame.up);
  }
  if (use.hidden.empty()) return note;
  return fmt::format("{}{}left out of it: {}", note, note.empty() ? "" : "; ",
                     fmt::join(use.hidden, ", "));
}

}  // namespace sightline
