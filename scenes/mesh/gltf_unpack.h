// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

using GltfBytes = std::vector<unsigned char>;

/// A glTF file whose compressed data lie in buffers of their own, plain.
struct UnpackedGltf {
  std::string json;
  /// The content of buffers by their URI: what was unpacked, and a .glb's own.
  std::map<std::string, GltfBytes> buffers;
};

/// Unpacks the buffer views of EXT_meshopt_compression (by meshoptimizer) and the primitives of
/// KHR_draco_mesh_compression (by Draco) of a .glb or .gltf, whose chunks must lie within it; none
/// where it has neither. `read` gives the buffer of a URI. Throws InputError, whose text says what
/// is wrong within the file, for data that cannot be decoded.
std::optional<UnpackedGltf> unpack_gltf(std::string_view bytes,
                                        const std::function<GltfBytes(const std::string&)>& read);

}  // namespace sightline
