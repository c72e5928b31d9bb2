// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/gl_context.h"

#include <array>
#include <cstdlib>

#include <GL/osmesa.h>

namespace sightline {
namespace {

class OsMesaContext : public GlContext {
 public:
  OsMesaContext() {
    // llvmpipe has one rasteriser lock a process: its threads cost time. Processes scale.
    setenv("LP_NUM_THREADS", "0", /*overwrite=*/0);
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
    context_ = OSMesaCreateContextAttribs(attributes, nullptr);
    if (context_ == nullptr) throw GraphicsError("OSMesa offers no OpenGL 4.5 core context");
    make_current();
  }
  OsMesaContext(const OsMesaContext&) = delete;
  OsMesaContext& operator=(const OsMesaContext&) = delete;
  ~OsMesaContext() override { OSMesaDestroyContext(context_); }

  void make_current() override {
    // Frames go to framebuffer objects; the window's own buffer is a formality.
    if (!OSMesaMakeCurrent(context_, window_.data(), GL_UNSIGNED_BYTE, 4, 4)) {
      throw GraphicsError("OSMesaMakeCurrent failed");
    }
  }

  void* address(const char* function) const override {
    return reinterpret_cast<void*>(OSMesaGetProcAddress(function));
  }

  std::string name() const override { return "osmesa"; }

 private:
  OSMesaContext context_ = nullptr;
  std::array<unsigned char, 4 * 4 * 4> window_{};
};

}  // namespace

std::unique_ptr<GlContext> make_osmesa_context() {
  return std::make_unique<OsMesaContext>();
}

}  // namespace sightline
