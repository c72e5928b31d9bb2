// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The textures of a mesh that is being read: found, measured and decoded in the reader's process.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "scenes/mesh/mesh_folder.h"
#include "scenes/mesh/mesh_soup.h"

namespace sightline {

constexpr int kMaxTextureSide = 16384;                   ///< px
constexpr int64_t kMaxTexturePixels = int64_t{1} << 26;  ///< of all of a mesh's textures: 256 MiB

/// Linear light of a number that is encoded as IEC 61966-2-1 says, both from 0 to 1.
double linear_from_srgb(double encoded);
/// Its inverse.
double srgb_from_linear(double linear);

/// The number within 0 and 1; 0 of what is no number.
double within_unit(double value);

/// Decodes a picture of a format that textures have here (PNG, JPEG, BMP, WebP, TIFF), 8 or 16
/// bits, one to four channels. Its size is known from its header before anything is decoded. Throws
/// InputError, whose text goes on after the texture's name ("is torn or damaged"), for one that is
/// torn, larger than kMaxTextureSide or than `pixels_left`, or of another format.
Texture decode_texture(std::string_view bytes, int64_t pixels_left);

/// Puts textures into a soup, each once. One that cannot be had is lost: the soup says why, in a
/// sentence, and the surface goes without.
class TextureShelf {
 public:
  TextureShelf(MeshSoup& soup, const std::filesystem::path& mesh_file);

  /// The index of the texture in a file, which a mesh names by a path that may come from another
  /// machine: it is looked for in the mesh's folder and below. -1 when it is lost.
  int from_file(const std::string& named, bool is_srgb);
  /// The index of a texture whose file's bytes are these; none: it is missing.
  int from_bytes(std::string_view bytes, const std::string& name, bool is_srgb);
  /// The index of a texture with the colours of one, or white ones of index -1, and the opacity of
  /// another: its alpha or, where it has none and is another picture, its brightness. The mode says
  /// what that opacity needs. Where it is everywhere 1, where both are one picture, or where no
  /// room is left (kOpaque, and the soup says so), the index is that of the colours. The opacity's
  /// own picture is let go if it came last: what is asked for again is read again.
  std::pair<int, AlphaMode> with_alpha(int colour, int alpha);
  /// Says why the texture of that name cannot be had; -1.
  int lose(const std::string& name, const std::string& reason);

 private:
  int add(const std::string& name, bool is_srgb, std::string_view bytes);
  int keep(Texture texture);
  void let_go(int index);
  int miss(const std::string& named);

  MeshSoup& soup_;
  MeshFolder folder_;
  std::map<std::pair<std::string, bool>, int> known_;
  int64_t pixels_left_ = kMaxTexturePixels;
};

}  // namespace sightline
