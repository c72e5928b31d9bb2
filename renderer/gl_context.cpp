// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/gl_context.h"

#include <cstdlib>

#include <dlfcn.h>
#include <fmt/format.h>

namespace sightline {
namespace {

constexpr std::string_view kNames[] = {"none", "auto", "osmesa", "egl"};

}  // namespace

std::span<const std::string_view> gl_choice_names() {
  return kNames;
}

std::optional<GlChoice> gl_choice(std::string_view name) {
  for (int i = 0; i < 4; ++i) {
    if (kNames[i] == name) return static_cast<GlChoice>(i);
  }
  return std::nullopt;
}

SharedLibrary::SharedLibrary(std::span<const char* const> sonames) {
  for (const char* soname : sonames) {
    handle_ = dlopen(soname, RTLD_NOW | RTLD_LOCAL);
    soname_ = soname;
    if (handle_ != nullptr) return;
  }
  throw GraphicsError(fmt::format("there is no {}", sonames.front()));
}

void* SharedLibrary::symbol(const char* name) const {
  void* address = dlsym(handle_, name);
  if (address == nullptr) throw GraphicsError(fmt::format("{} lacks {}", soname_, name));
  return address;
}

std::unique_ptr<GlContext> make_gl_context(GlChoice choice) {
  // llvmpipe has one rasteriser lock a process: its threads cost time. Processes scale.
  setenv("LP_NUM_THREADS", "0", /*overwrite=*/0);
  if (choice == GlChoice::kOsMesa) return make_osmesa_context();
  if (choice == GlChoice::kEgl) return make_egl_context();
  std::string reasons;
  for (const auto make : {make_osmesa_context, make_egl_context}) {
    try {
      return make();
    } catch (const GraphicsError& error) {
      reasons += fmt::format("{}{}", reasons.empty() ? "" : "; ", error.what());
    }
  }
  throw GraphicsError("there is no OpenGL: " + reasons);
}

}  // namespace sightline
