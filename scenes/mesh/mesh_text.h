// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>

namespace sightline {

/// The extension in lower case, with its dot.
std::string lower_extension(const std::filesystem::path& file);

/// What a file is that is no mesh, and what to do about it, by its extension or its first bytes:
/// CAD models, USD scenes, robots, materials. Empty where it may be a mesh.
std::string why_no_mesh(const std::filesystem::path& file, std::string_view beginning);

/// Metres in a unit of a COLLADA file, by its <unit>; 1 where it has none.
double collada_unit_m(std::string_view text);

/// Metres in a unit of a 3MF model, by the attribute of its text; a thousandth where it has none,
/// as the 3MF Core Specification 1.3 (3.4) says.
double threemf_unit_m(std::string_view text);

/// How the first file of a ZIP archive whose name ends so begins, some thousand bytes of it; empty
/// where there is none, or it is packed otherwise than by "deflate" or not at all.
std::string beginning_in_zip(std::string_view archive, std::string_view ending);

/// An .stl as Assimp wants it: a binary one without what follows its triangles, a text one with
/// keywords in lower case. Empty where it is so already.
std::string tidy_stl(std::string_view bytes);

/// Names as a line tells them: "a, b and 3 more".
std::string listed(const std::set<std::string>& names);

}  // namespace sightline
