// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/gl_context.h"

#if __has_include(<GL/osmesa.h>)

#include <array>

#include <GL/osmesa.h>

namespace sightline {
namespace {

constexpr const char* kOsmesaSonames[] = {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"};

class OsMesaContext : public GlContext {
 public:
  OsMesaContext() {
    const int attributes[] = {OSMESA_FORMAT,
                              OSMESA_RGBA,
                              OSMESA_DEPTH_BITS,
                              0,
                              OSMESA_PROFILE,
                              OSMESA_CORE_PROFILE,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              4,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              5,
                              0};
    using Create = decltype(&OSMesaCreateContextAttribs);
    context_ = library_.function<Create>("OSMesaCreateContextAttribs")(attributes, nullptr);
    if (context_ == nullptr) throw GraphicsError("OSMesa offers no OpenGL 4.5 core context");
  }
  OsMesaContext(const OsMesaContext&) = delete;
  OsMesaContext& operator=(const OsMesaContext&) = delete;
  ~OsMesaContext() override {
    library_.function<decltype(&OSMesaDestroyContext)>("OSMesaDestroyContext")(context_);
  }

  void make_current() override {
    // Frames go to framebuffer objects; the window's own buffer is a formality.
    if (!make_current_(context_, window_.data(), GL_UNSIGNED_BYTE, 4, 4)) {
      throw GraphicsError("OSMesaMakeCurrent failed");
    }
  }

  void release() override { make_current_(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }

  void* address(const char* function) const override {
    return reinterpret_cast<void*>(address_(function));
  }

  std::string name() const override { return "osmesa"; }

 private:
  SharedLibrary library_{kOsmesaSonames};
  decltype(&OSMesaMakeCurrent) make_current_ =
      library_.function<decltype(&OSMesaMakeCurrent)>("OSMesaMakeCurrent");
  decltype(&OSMesaGetProcAddress) address_ =
      library_.function<decltype(&OSMesaGetProcAddress)>("OSMesaGetProcAddress");
  OSMesaContext context_ = nullptr;
  std::array<unsigned char, 4 * 4 * 4> window_{};
};

}  // namespace

std::unique_ptr<GlContext> make_osmesa_context() {
  return std::make_unique<OsMesaContext>();
}

}  // namespace sightline

#else

namespace sightline {

std::unique_ptr<GlContext> make_osmesa_context() {
  throw GraphicsError("this build knows no OSMesa (GL/osmesa.h was missing)");
}

}  // namespace sightline

#endif
