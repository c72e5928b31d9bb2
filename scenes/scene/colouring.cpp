// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/colouring.h"

#include <algorithm>

#include <fmt/format.h>

namespace sightline {

std::vector<Key> keys_of(ColouringLaw& law, Colouring& colouring) {
  return {
      {"image",
       "colour",
       choice(
           law.mode,
           {{"grey", ColourMode::kGrey}, {"rgb", ColourMode::kRgb}, {"bayer", ColourMode::kBayer}}),
       {},
       "",
       "whether pictures are grey, or red, green and blue with the materials of the meshes' files; "
       "bayer: by a mosaic of red, green, green and blue photosites, interpolated bilinearly",
       choice(colouring.mode, {{"grey", ColourMode::kGrey},
                               {"rgb", ColourMode::kRgb},
                               {"bayer", ColourMode::kBayer}})},
      {"image",
       "textures",
       &law.draws_textures,
       {},
       "",
       "whether textures and the colours of vertices are drawn, in grey by their luminance",
       &colouring.draws_textures},
      {"image",
       "missing_textures",
       choice(law.takes_missing, {{"refuse", false}, {"grey", true}}),
       {},
       "",
       "what becomes of a mesh whose file names a texture that is missing, torn, too large or of "
       "an unknown format; grey draws it without, and says so",
       choice(colouring.takes_missing, {{"refuse", false}, {"grey", true}}),
       "takes_missing"},
      {"image",
       "truth_sees",
       choice(law.truth_sees,
              {{"nearest", TruthSurface::kNearest}, {"opaque", TruthSurface::kOpaque}}),
       {},
       "",
       "of which surface depth, ids and masks are where one shows what is behind: the nearest, or "
       "the nearest that lets no light through and, where there is none, the nearest that is seen; "
       "for pictures in colour",
       choice(colouring.truth_sees,
              {{"nearest", TruthSurface::kNearest}, {"opaque", TruthSurface::kOpaque}})},
  };
}

ColouringLaw read_colouring(const TomlTable& file) {
  ColouringLaw law;
  Colouring colouring;
  read_keys(file, keys_of(law, colouring));
  if (law.truth_sees == TruthSurface::kOpaque && law.mode == ColourMode::kGrey) {
    file.table("image").fail("truth_sees",
                             "is \"opaque\", which needs image.colour = \"rgb\" or \"bayer\": in "
                             "grey all surfaces are opaque");
  }
  return law;
}

void require_textures(const TomlTable& file, const ColouringLaw& law, const std::string& target,
                      const Mesh& mesh) {
  if (!law.draws_textures || law.takes_missing || mesh.lost_textures.empty()) return;
  const size_t more = mesh.lost_textures.size() - 1;
  file.fail("target",
            fmt::format("'{}': {}{}; image.missing_textures = \"grey\" (--missing-textures grey) "
                        "draws it without",
                        target, mesh.lost_textures.front(),
                        more == 0 ? "" : fmt::format(", and {} more are lost", more)));
}

std::vector<std::string> surface_notes(const ColouringLaw& law, const Mesh& mesh) {
  std::vector<std::string> notes = mesh.notes;
  if (law.draws_textures) {
    for (const std::string& lost : mesh.lost_textures) notes.push_back(lost + ": drawn without it");
  }
  const bool is_grey = law.mode == ColourMode::kGrey;
  if (is_grey && law.draws_textures && !mesh.coats.empty()) {
    notes.emplace_back(
        "its textures or colours are drawn as grey (image.textures = false: not at "
        "all; image.colour = \"rgb\": in colour)");
  }
  const auto see_through = [](const Part& part) {
    return part.material && part.material->alpha_mode != AlphaMode::kOpaque;
  };
  const auto count = std::count_if(mesh.parts.begin(), mesh.parts.end(), see_through);
  if (count > 0) {
    const char* verb = count == 1 ? " is" : "s are";
    notes.push_back(
        is_grey
            ? fmt::format("{} see-through part{} drawn opaque (image.colour = \"rgb\": as they "
                          "are)",
                          count, verb)
            : fmt::format("{} see-through part{} opaque to {}features and shadows", count, verb,
                          law.truth_sees == TruthSurface::kNearest ? "depth, ids, masks, " : ""));
  }
  return notes;
}

Colouring draw_colouring(ColouringLaw law, const Draws& draws) {
  Colouring colouring;
  draw_keys(keys_of(law, colouring), draws);
  return colouring;
}

std::vector<Fact> facts_of(Colouring colouring) {
  if (colouring.mode == ColourMode::kGrey) return {};
  ColouringLaw law;
  std::vector<Fact> facts = facts_of(keys_of(law, colouring));
  if (colouring.truth_sees == TruthSurface::kNearest) {
    std::erase_if(facts, [](const Fact& fact) { return fact.name == "truth_sees"; });
  }
  return facts;
}

}  // namespace sightline
