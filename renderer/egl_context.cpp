// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/gl_context.h"

#if __has_include(<EGL/eglext.h>)

#define EGL_NO_X11
#include <cstdlib>

#include <EGL/egl.h>
#include <EGL/eglext.h>

namespace sightline {
namespace {

constexpr const char* kEglSonames[] = {"libEGL.so.1", "libEGL.so"};

class EglContext : public GlContext {
 public:
  EglContext() {
    // As with OSMesa: the same pictures whatever graphics card there is.
    setenv("LIBGL_ALWAYS_SOFTWARE", "1", /*overwrite=*/0);
    const auto get_display =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(address_("eglGetPlatformDisplayEXT"));
    if (get_display == nullptr) throw GraphicsError("EGL has no platform displays");
    display_ = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    // Displays are shared by all contexts of the process, and never terminated.
    if (display_ == EGL_NO_DISPLAY ||
        !library_.function<decltype(&eglInitialize)>("eglInitialize")(display_, nullptr, nullptr)) {
      throw GraphicsError("EGL has no display without a surface");
    }
    if (!bind_api_(EGL_OPENGL_API)) throw GraphicsError("EGL offers no desktop OpenGL");
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    context_ = library_.function<decltype(&eglCreateContext)>("eglCreateContext")(
        display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (context_ == EGL_NO_CONTEXT) throw GraphicsError("EGL offers no OpenGL 4.5 core context");
  }
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;
  ~EglContext() override {
    library_.function<decltype(&eglDestroyContext)>("eglDestroyContext")(display_, context_);
  }

  void make_current() override {
    bind_api_(EGL_OPENGL_API);
    if (!make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) {
      throw GraphicsError("eglMakeCurrent failed");
    }
  }

  void release() override {
    make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }

  void* address(const char* function) const override {
    return reinterpret_cast<void*>(address_(function));
  }

  std::string name() const override { return "egl"; }

 private:
  SharedLibrary library_{kEglSonames};
  decltype(&eglGetProcAddress) address_ =
      library_.function<decltype(&eglGetProcAddress)>("eglGetProcAddress");
  decltype(&eglBindAPI) bind_api_ = library_.function<decltype(&eglBindAPI)>("eglBindAPI");
  decltype(&eglMakeCurrent) make_current_ =
      library_.function<decltype(&eglMakeCurrent)>("eglMakeCurrent");
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

std::unique_ptr<GlContext> make_egl_context() {
  return std::make_unique<EglContext>();
}

}  // namespace sightline

#else

namespace sightline {

std::unique_ptr<GlContext> make_egl_context() {
  throw GraphicsError("this build knows no EGL (EGL/eglext.h was missing)");
}

}  // namespace sightline

#endif
