// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What of a surface's colours a picture shows: colour, textures and missing_textures of [image].
#pragma once

#include <string>
#include <vector>

#include "scenes/mesh/mesh.h"
#include "scenes/scene/keys.h"

namespace sightline {

enum class ColourMode {
  kGrey,   ///< one channel: surfaces are dull, and as bright as the luminance of their colour
           ///< and emission
  kRgb,    ///< three channels, and the materials of the meshes' files
  kBayer,  ///< the same through a sensor whose photosites see one colour each
};

/// Which of the surfaces along a pixel's ray the truth is of, where some let light through.
enum class TruthSurface {
  kNearest,  ///< the nearest, whatever its alpha
  kOpaque,   ///< the nearest that lets no light through; where there is none, the nearest that is
             ///< seen at all (its alpha is not 0)
};

struct Colouring {
  ColourMode mode = ColourMode::kGrey;
  bool draws_textures = true;  ///< and the colours of vertices; else factors alone
  bool takes_missing = false;  ///< a texture that is lost does not matter
  TruthSurface truth_sees = TruthSurface::kNearest;
};

/// What a file says of it, the same for all frames.
struct ColouringLaw {
  ColourMode mode = Colouring{}.mode;
  bool draws_textures = Colouring{}.draws_textures;
  bool takes_missing = Colouring{}.takes_missing;
  TruthSurface truth_sees = Colouring{}.truth_sees;
};

std::vector<Key> keys_of(ColouringLaw& law, Colouring& colouring);

/// Throws InputError.
ColouringLaw read_colouring(const TomlTable& file);

/// Throws InputError, naming the texture, where the law asks for textures and the mesh of this
/// target has lost one.
void require_textures(const TomlTable& file, const ColouringLaw& law, const std::string& target,
                      const Mesh& mesh);

/// What a user should know of how a mesh's surfaces are drawn, a sentence each: textures that are
/// lost, textures in grey, what is see-through and drawn opaque.
std::vector<std::string> surface_notes(const ColouringLaw& law, const Mesh& mesh);

Colouring draw_colouring(ColouringLaw law, const Draws& draws);

/// What the truth states of it: nothing of grey pictures, whose truth has always been without, and
/// of truth_sees where that is not the nearest.
std::vector<Fact> facts_of(Colouring colouring);

}  // namespace sightline
