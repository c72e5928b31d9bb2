// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "renderer/gl_context.h"
#include "renderer/visibility.h"

namespace sightline {

/// OpenGL as painter: the lattice of samples is drawn as one skewed image of ids, cut into tiles.
/// It sees what our own painter sees but for its vertices, which it rounds to 1/256 of the distance
/// between samples. Not for kNone. Throws GraphicsError when there is no context to be had.
std::unique_ptr<SamplePainter> make_gl_painter(GlChoice choice);

}  // namespace sightline
