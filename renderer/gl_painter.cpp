// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/gl_painter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "renderer/gl_functions.h"

namespace sightline {
namespace {

// Bounds memory: a tile has 8 bytes a sample here, and 4 there.
constexpr int64_t kMaxTileSamples = 1 << 22;
constexpr int kMaxTileSide = 8192;
// As well: the library has a copy of them of its own.
constexpr size_t kMaxVertices = 3'000'000;

constexpr const char* kVertexShader = R"(#version 450 core
layout(location = 0) in vec3 position;  // clip coordinates
layout(location = 1) in uint id;
flat out uint surface_id;
void main() {
  gl_Position = vec4(position, 1.0);
  surface_id = id;
}
)";

constexpr const char* kFragmentShader = R"(#version 450 core
flat in uint surface_id;
layout(location = 0) out uint id;
void main() {
  id = surface_id;
}
)";

struct Vertex {
  float position[3];
  GLuint id;
};

// What of the skewed image one tile of the image needs: columns and rows of the lattice.
struct SkewedBox {
  int left, top, width, height;
  int64_t area() const { return static_cast<int64_t>(width) * height; }
};

class GlPainter : public SamplePainter {
 public:
  explicit GlPainter(GlChoice choice) : context_(make_gl_context(choice)) {
    const CurrentContext current(*context_);
    gl_ = load_gl_functions(*context_);
    link();
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.DepthFunc(GL_LESS);
    gl_.GenVertexArrays(1, &vertex_array_);
    gl_.BindVertexArray(vertex_array_);
    gl_.GenBuffers(1, &buffer_);
    gl_.BindBuffer(GL_ARRAY_BUFFER, buffer_);
    const auto offset = [](size_t bytes) { return reinterpret_cast<const void*>(bytes); };
    gl_.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                            offset(offsetof(Vertex, position)));
    gl_.VertexAttribIPointer(1, 1, GL_UNSIGNED_INT, sizeof(Vertex), offset(offsetof(Vertex, id)));
    for (const GLuint i : {0u, 1u}) gl_.EnableVertexAttribArray(i);
    gl_.UseProgram(program_);
    const auto text = [this](GLenum name) {
      const auto* value = reinterpret_cast<const char*>(gl_.GetString(name));
      return std::string(value == nullptr ? "unknown" : value);
    };
    description_ = fmt::format("{}: {}, {}", context_->name(), text(GL_RENDERER), text(GL_VERSION));
  }
  GlPainter(const GlPainter&) = delete;
  GlPainter& operator=(const GlPainter&) = delete;

  ~GlPainter() override {
    try {
      const CurrentContext current(*context_);
      release_framebuffer();
      gl_.DeleteVertexArrays(1, &vertex_array_);
      gl_.DeleteBuffers(1, &buffer_);
      gl_.DeleteProgram(program_);
    } catch (const GraphicsError&) {
      // Without a current context there is nothing to release.
    }
  }

  void start(const ScreenMesh& mesh, const PixelBox& box, const SamplePattern& pattern) override {
    mesh_ = &mesh;
    pattern_ = &pattern;
    sample_cells_.clear();
    const auto& m = pattern.skewed_from_pixel;
    for (int k = 0; k < pattern.count; ++k) {
      const double x = pattern.x[k] - pattern.first[0];
      const double y = pattern.y[k] - pattern.first[1];
      sample_cells_.push_back({static_cast<int>(std::lround(m[0] * x + m[1] * y)),
                               static_cast<int>(std::lround(m[2] * x + m[3] * y))});
    }
    tiles_.clear();
    if (!box.is_empty()) cut_into_tiles(box);
    std::reverse(tiles_.begin(), tiles_.end());
    farthest_ = std::numeric_limits<double>::infinity();
    nearest_ = -farthest_;
    for (const ScreenTriangle& triangle : mesh.triangles) {
      for (const ScreenPoint& corner : mesh.corners_of(triangle)) {
        farthest_ = std::min(farthest_, corner.nearness);
        nearest_ = std::max(nearest_, corner.nearness);
      }
    }
  }

  bool next(VisibleStrip& strip) override {
    if (tiles_.empty()) return false;
    strip.box = tiles_.back();
    tiles_.pop_back();
    const SkewedBox skewed = skewed_box(strip.box);
    const CurrentContext current(*context_);
    draw(strip.box, skewed);
    gl_.Finish();
    const auto begin = std::chrono::steady_clock::now();
    cells_.resize(skewed.area());
    gl_.ReadPixels(0, 0, skewed.width, skewed.height, GL_RED_INTEGER, GL_UNSIGNED_INT,
                   cells_.data());
    const GLenum error = gl_.GetError();
    if (error != GL_NO_ERROR) throw GraphicsError(fmt::format("OpenGL error 0x{:x}", error));
    gather(skewed, strip);
    const auto end = std::chrono::steady_clock::now();
    strip.readback_ms = std::chrono::duration<double, std::milli>(end - begin).count();
    return true;
  }

  std::string description() const override { return description_; }

 private:
  struct Cell {
    int column, row;
  };

  GLuint compile(GLenum stage, const char* source) {
    const GLuint shader = gl_.CreateShader(stage);
    gl_.ShaderSource(shader, 1, &source, nullptr);
    gl_.CompileShader(shader);
    GLint compiled = 0;
    gl_.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled != 0) return shader;
    char log[2048] = {};
    gl_.GetShaderInfoLog(shader, sizeof log, nullptr, log);
    throw GraphicsError(fmt::format("shader does not compile: {}", log));
  }

  void link() {
    const GLuint vertex = compile(GL_VERTEX_SHADER, kVertexShader);
    const GLuint fragment = compile(GL_FRAGMENT_SHADER, kFragmentShader);
    program_ = gl_.CreateProgram();
    gl_.AttachShader(program_, vertex);
    gl_.AttachShader(program_, fragment);
    gl_.LinkProgram(program_);
    gl_.DeleteShader(vertex);
    gl_.DeleteShader(fragment);
    GLint linked = 0;
    gl_.GetProgramiv(program_, GL_LINK_STATUS, &linked);
    if (linked != 0) return;
    char log[2048] = {};
    gl_.GetProgramInfoLog(program_, sizeof log, nullptr, log);
    throw GraphicsError(fmt::format("program does not link: {}", log));
  }

  SkewedBox skewed_box(const PixelBox& box) const {
    int left = INT32_MAX, top = INT32_MAX, right = INT32_MIN, bottom = INT32_MIN;
    const auto& m = pattern_->skewed_from_pixel;
    for (const int x : {box.left, box.right - 1}) {
      for (const int y : {box.top, box.bottom - 1}) {
        for (const Cell& cell : sample_cells_) {
          const int column = m[0] * x + m[1] * y + cell.column;
          const int row = m[2] * x + m[3] * y + cell.row;
          left = std::min(left, column);
          right = std::max(right, column + 1);
          top = std::min(top, row);
          bottom = std::max(bottom, row + 1);
        }
      }
    }
    return {left, top, right - left, bottom - top};
  }

  // NOLINTNEXTLINE(misc-no-recursion): halves the box each time.
  void cut_into_tiles(const PixelBox& box) {
    const SkewedBox skewed = skewed_box(box);
    const bool fits =
        skewed.area() <= kMaxTileSamples && std::max(skewed.width, skewed.height) <= kMaxTileSide;
    if (fits || (box.width() == 1 && box.height() == 1)) {
      tiles_.push_back(box);
      return;
    }
    PixelBox first = box;
    PixelBox second = box;
    if (box.width() > box.height()) {
      first.right = second.left = (box.left + box.right) / 2;
    } else {
      first.bottom = second.top = (box.top + box.bottom) / 2;
    }
    cut_into_tiles(first);
    cut_into_tiles(second);
  }

  void draw(const PixelBox& box, const SkewedBox& skewed) {
    bind_framebuffer(skewed.width, skewed.height);
    const GLuint none[4] = {};
    const float far_depth = 1;
    gl_.ClearBufferuiv(GL_COLOR, 0, none);
    gl_.ClearBufferfv(GL_DEPTH, 0, &far_depth);
    // The nearest at -0.9, the farthest at 0.9: rounding must not clip either.
    const double depth_scale = nearest_ > farthest_ ? -1.8 / (nearest_ - farthest_) : 0;
    const auto& m = pattern_->skewed_from_pixel;
    vertices_.clear();
    for (const ScreenTriangle& triangle : mesh_->triangles) {
      const auto corners = mesh_->corners_of(triangle);
      if (touched_box(corners, box).is_empty()) continue;
      for (const ScreenPoint& corner : corners) {
        const double x = corner.x - pattern_->first[0];
        const double y = corner.y - pattern_->first[1];
        const double column = m[0] * x + m[1] * y - skewed.left + 0.5;
        const double row = m[2] * x + m[3] * y - skewed.top + 0.5;
        const double depth = 0.9 + depth_scale * (corner.nearness - farthest_);
        vertices_.push_back(
            {{static_cast<float>(2 * column / skewed.width - 1),
              static_cast<float>(2 * row / skewed.height - 1), static_cast<float>(depth)},
             triangle.id});
      }
      if (vertices_.size() >= kMaxVertices) draw_vertices();
    }
    draw_vertices();
  }

  // Draws what has been gathered, over what was drawn before.
  void draw_vertices() {
    if (vertices_.empty()) return;
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices_.size() * sizeof(Vertex)),
                   vertices_.data(), GL_STREAM_DRAW);
    gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices_.size()));
    vertices_.clear();
  }

  void gather(const SkewedBox& skewed, VisibleStrip& strip) const {
    const size_t pixels = static_cast<size_t>(strip.box.width()) * strip.box.height();
    strip.is_touched.assign(pixels, 0);
    strip.ids.resize(std::max(strip.ids.size(), pixels * pattern_->count));
    const auto& m = pattern_->skewed_from_pixel;
    uint32_t* id = strip.ids.data();
    for (int y = strip.box.top; y < strip.box.bottom; ++y) {
      for (int x = strip.box.left; x < strip.box.right; ++x) {
        const int column = m[0] * x + m[1] * y - skewed.left;
        const int row = m[2] * x + m[3] * y - skewed.top;
        uint32_t any = 0;
        for (const Cell& cell : sample_cells_) {
          *id = cells_[static_cast<size_t>(row + cell.row) * skewed.width + column + cell.column];
          any |= *id++;
        }
        strip.is_touched[strip.pixel(x, y)] = any != 0;
      }
    }
  }

  // Framebuffers grow, never shrink.
  void bind_framebuffer(int width, int height) {
    if (width > width_ || height > height_) {
      const int new_width = std::max(width, width_);
      const int new_height = std::max(height, height_);
      release_framebuffer();
      gl_.GenFramebuffers(1, &framebuffer_);
      gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
      ids_ = attach(GL_R32UI, GL_COLOR_ATTACHMENT0, new_width, new_height);
      depth_ = attach(GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT, new_width, new_height);
      if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        throw GraphicsError(fmt::format("no framebuffer of {} x {}", new_width, new_height));
      }
      width_ = new_width;
      height_ = new_height;
    }
    gl_.Viewport(0, 0, width, height);
  }

  GLuint attach(GLenum format, GLenum attachment, int width, int height) {
    GLuint renderbuffer = 0;
    gl_.GenRenderbuffers(1, &renderbuffer);
    gl_.BindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
    gl_.RenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, renderbuffer);
    return renderbuffer;
  }

  void release_framebuffer() {
    if (framebuffer_ == 0) return;
    gl_.DeleteFramebuffers(1, &framebuffer_);
    for (const GLuint buffer : {ids_, depth_}) gl_.DeleteRenderbuffers(1, &buffer);
    framebuffer_ = 0;
    width_ = height_ = 0;
  }

  std::unique_ptr<GlContext> context_;
  GlFunctions gl_;
  std::string description_;
  GLuint program_ = 0, vertex_array_ = 0, buffer_ = 0;
  GLuint framebuffer_ = 0, ids_ = 0, depth_ = 0;
  int width_ = 0, height_ = 0;  // of the framebuffer

  const ScreenMesh* mesh_ = nullptr;
  const SamplePattern* pattern_ = nullptr;
  std::vector<Cell> sample_cells_;  // of a pixel's samples, beside the pixel's own
  std::vector<PixelBox> tiles_;     // the next one last
  double nearest_ = 0, farthest_ = 0;
  std::vector<Vertex> vertices_;
  std::vector<uint32_t> cells_;
};

}  // namespace

std::unique_ptr<SamplePainter> make_gl_painter(GlChoice choice) {
  return std::make_unique<GlPainter>(choice);
}

}  // namespace sightline
