// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <compare>
#include <filesystem>
#include <string>
#include <vector>

#include "scenes/mesh/mesh_io.h"

namespace sightline {

/// How a mesh is taken, as the command line or [mesh] of a scene file says it; empty: not said.
struct MeshUse {
  std::string forward;  ///< the axis of a mesh file that points forward, such as "-x"
  std::string up;       ///< and the one that points up
  std::string unit;     ///< its unit, as `unit_named` takes it
  /// Parts that are left out, by name; "*" stands for any letters, "?" for one.
  std::vector<std::string> hidden = {};
  std::string backfaces = {};  ///< "seen": all materials are two-sided; "material": as they say

  bool says_frame() const { return !(forward + up + unit).empty(); }
  auto operator<=>(const MeshUse&) const = default;
};

/// The frame that is meant. Throws InputError for a wrong unit.
MeshFrame frame_of(const MeshUse& use);

/// Takes the triangles of hidden parts from a mesh, and the vertices that no other has; the parts
/// stay in its list, so that the others keep their ids. Throws InputError, naming the file, where a
/// name fits no part, or nothing would be left.
void hide_parts(const std::vector<std::string>& hidden, const std::filesystem::path& file,
                Mesh& mesh);

/// Makes materials two-sided where the use says so, or nobody sees a back: all with one side are
/// closed and turned outward. Else one clause says what may not be seen, if anything. Throws
/// InputError for a word that is none.
std::string take_backfaces(const MeshUse& use, Mesh& mesh);

/// One clause that says how a mesh was taken: of a mesh file its unit and axes, and what of it was
/// left out. Empty where there is nothing to say.
std::string taken_note(const MeshUse& use, bool is_mesh_file);

}  // namespace sightline
