// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/gl_functions.h"

namespace sightline {
namespace {

template <typename Function>
Function load(const GlContext& context, const char* name) {
  void* address = context.address(name);
  if (address == nullptr) {
    throw GraphicsError("the context '" + context.name() + "' lacks " + name);
  }
  return reinterpret_cast<Function>(address);
}

}  // namespace

GlFunctions load_gl_functions(const GlContext& context) {
  GlFunctions gl;
#define SIGHTLINE_LOAD(type, name) gl.name = load<type>(context, "gl" #name);
  SIGHTLINE_GL_FUNCTIONS(SIGHTLINE_LOAD)
#undef SIGHTLINE_LOAD
  return gl;
}

}  // namespace sightline
