// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/obj_text.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sightline {
namespace {

// A vertex of a line "v x y z ...", and where the text goes on behind it.
struct ObjVertex {
  Eigen::Vector3d x;
  size_t rest = 0;
};

std::optional<ObjVertex> vertex_of(std::string_view line) {
  if (line.size() < 2 || line[0] != 'v' || (line[1] != ' ' && line[1] != '\t')) return std::nullopt;
  ObjVertex vertex;
  const char* at = line.data() + 1;
  const char* const end = line.data() + line.size();
  for (double& number : vertex.x) {
    while (at < end && (*at == ' ' || *at == '\t' || *at == '+')) ++at;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc()) return std::nullopt;
    at = next;
  }
  vertex.rest = static_cast<size_t>(at - line.data());
  return vertex;
}

// Calls with every line, its end included, until told to stop by false.
template <typename Visit>
void for_each_line(std::string_view text, const Visit& visit) {
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    if (!visit(text.substr(0, end))) return;
    text.remove_prefix(end);
  }
}

Eigen::AlignedBox3d box_of(std::string_view obj, size_t most_vertices) {
  Eigen::AlignedBox3d box;
  size_t count = 0;
  for_each_line(obj, [&](std::string_view line) {
    const auto vertex = vertex_of(line);
    if (vertex && vertex->x.allFinite()) {
      box.extend(vertex->x);
      ++count;
    }
    return count < most_vertices;
  });
  return box;
}

bool is_far(const Eigen::AlignedBox3d& box) {
  return !box.isEmpty() && box.center().norm() > kFarSizes * box.diagonal().norm();
}

}  // namespace

std::optional<Eigen::Vector3d> far_middle(std::string_view obj) {
  // The box of some is no larger than that of all: what is not far by them is not far.
  constexpr size_t kSome = 1000;
  if (!is_far(box_of(obj, kSome))) return std::nullopt;
  const Eigen::AlignedBox3d box = box_of(obj, std::numeric_limits<size_t>::max());
  if (!is_far(box) || !(box.diagonal().norm() > 0)) return std::nullopt;
  const Eigen::Vector3d rounded = box.center().array().round();
  return rounded;
}

std::string moved_obj(std::string_view obj, const Eigen::Vector3d& by) {
  std::string out;
  out.reserve(obj.size());
  for_each_line(obj, [&](std::string_view line) {
    const auto vertex = vertex_of(line);
    if (vertex) {
      const Eigen::Vector3d x = vertex->x - by;
      out += fmt::format("v {} {} {}", x.x(), x.y(), x.z());
    }
    out += line.substr(vertex ? vertex->rest : 0);
    return true;
  });
  return out;
}

}  // namespace sightline
