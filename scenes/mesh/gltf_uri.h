// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The names by which a glTF file calls other files.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sightline {

/// The path that a URI means: "%20" is a space, and "+" is itself (RFC 3986).
std::string path_of_uri(std::string_view uri);

/// A .gltf or .glb with every "+" in the names of files as "%2B", since tinygltf takes it for a
/// space; none where there is nothing to change.
std::optional<std::string> with_escaped_pluses(std::string_view gltf);

}  // namespace sightline
