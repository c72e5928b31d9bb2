// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "scenes/mesh/mesh.h"

namespace sightline {

/// The vertices of a PLY file (Turk, The PLY polygon file format, 1994), in its order and unit,
/// none welded, dropped or added, with the faces as triangles. `read_mesh` (scenes/mesh/mesh_io.h),
/// which cleans, would change the means over vertices that BOP's errors are. Any format, element
/// and type of number is read, and what is neither a vertex's place nor a face's corners is left
/// out. Throws InputError, with the file, where it is no PLY, ends too early, or has no vertices, a
/// vertex that is not finite, a face with a vertex that is not there or with over 100 000 corners,
/// or more triangles than kMaxTriangles (scenes/mesh/mesh_soup.h).
Mesh read_ply_as_it_is(const std::filesystem::path& file);

}  // namespace sightline
