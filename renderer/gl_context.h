// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace sightline {

/// The graphics library cannot do what rendering needs; what() names the call.
class GraphicsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Which OpenGL, if any. All of them draw in software.
enum class GlChoice {
  kNone,    ///< our own rasteriser, which needs no graphics library
  kAuto,    ///< the first that exists: OSMesa, then EGL
  kOsMesa,  ///< Mesa's off-screen library, which ends with Mesa 25.0
  kEgl,     ///< EGL without a surface, Mesa's or another vendor's
};

/// What may be typed for a choice: none, auto, osmesa, egl.
std::span<const std::string_view> gl_choice_names();
/// None for any other word.
std::optional<GlChoice> gl_choice(std::string_view name);

/// A way to an OpenGL 4.5 core context without a window or a display. Only renderer/ knows which.
/// Its library is opened when a context is made, so that a program without it runs.
class GlContext {
 public:
  virtual ~GlContext() = default;
  virtual void make_current() = 0;
  /// Leaves the thread without a context: two libraries must not both believe theirs is current.
  virtual void release() = 0;
  /// The address of a GL function of this context.
  virtual void* address(const char* function) const = 0;
  virtual std::string name() const = 0;
};

/// The context of a choice other than kNone. Throws GraphicsError when it cannot be had; the text
/// says why, of kAuto for each.
std::unique_ptr<GlContext> make_gl_context(GlChoice choice);

/// One way each; a build without a library's headers has none.
std::unique_ptr<GlContext> make_osmesa_context();
std::unique_ptr<GlContext> make_egl_context();

/// Makes a context current for as long as this lives.
class CurrentContext {
 public:
  explicit CurrentContext(GlContext& context) : context_(context) { context_.make_current(); }
  ~CurrentContext() { context_.release(); }
  CurrentContext(const CurrentContext&) = delete;
  CurrentContext& operator=(const CurrentContext&) = delete;

 private:
  GlContext& context_;
};

/// A shared library that is opened when it is needed and never closed: Mesa keeps threads and
/// thread-local data of its own.
class SharedLibrary {
 public:
  /// The first of these sonames that exists. Throws GraphicsError when none does.
  explicit SharedLibrary(std::span<const char* const> sonames);

  /// Throws GraphicsError when the library lacks it.
  template <typename Function>
  Function function(const char* name) const {
    return reinterpret_cast<Function>(symbol(name));
  }

 private:
  void* symbol(const char* name) const;

  void* handle_ = nullptr;
  std::string soname_;
};

}  // namespace sightline
