// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

namespace sightline {

/// The graphics library cannot do what rendering needs; what() names the call.
class GraphicsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A way to an OpenGL 4.5 core context without a window or a display. Only renderer/ knows which.
class GlContext {
 public:
  virtual ~GlContext() = default;
  virtual void make_current() = 0;
  /// The address of a GL function of this context.
  virtual void* address(const char* function) const = 0;
  virtual std::string name() const = 0;
};

/// Mesa's off-screen software context. Throws GraphicsError when it cannot be had.
std::unique_ptr<GlContext> make_osmesa_context();

}  // namespace sightline
