// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "renderer/gl_functions.h"
#include "renderer/sensor.h"
#include "scenes/input_error.h"

namespace sightline {
namespace {

// The largest framebuffer: a tile of the image with its samples. Bounds memory, not image size.
constexpr int kMaxTileSamples = 4096;

constexpr const char* kVertexShader = R"(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float albedo;
layout(location = 3) in uint part_id;
uniform mat4 clip_from_target;
uniform vec4 relative_depth;  // z_cam - z0 = dot(relative_depth, (position, 1))
out vec3 shading_normal;
out float surface_albedo;
out float z_minus_z0;
flat out uint surface_id;
void main() {
  gl_Position = clip_from_target * vec4(position, 1.0);
  shading_normal = normal;
  surface_albedo = albedo;
  z_minus_z0 = dot(relative_depth, vec4(position, 1.0));
  surface_id = part_id;
}
)";

constexpr const char* kImageShader = R"(#version 450 core
in vec3 shading_normal;
in float surface_albedo;
uniform vec3 to_light;  // unit, target's frame
uniform float ambient;
uniform float directional;
layout(location = 0) out float grey;
void main() {
  // A back face is the inside of an open mesh: it is lit as a sheet of paper is.
  vec3 n = normalize(gl_FrontFacing ? shading_normal : -shading_normal);
  grey = surface_albedo * (ambient + directional * max(0.0, dot(n, to_light)));
}
)";

constexpr const char* kTruthShader = R"(#version 450 core
in float z_minus_z0;
flat in uint surface_id;
layout(location = 0) out float depth;
layout(location = 1) out uint id;
void main() {
  depth = z_minus_z0;
  id = surface_id;
}
)";

struct Vertex {
  float position[3];
  float normal[3];
  float albedo;
  GLuint part_id;
};

std::vector<Vertex> vertices_of(const Mesh& mesh) {
  std::vector<Vertex> vertices;
  vertices.reserve(3 * mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3f p = mesh.vertices[triangle.vertex[c]].cast<float>();
      const Eigen::Vector3f n = triangle.normal[c].cast<float>();
      vertices.push_back({{p.x(), p.y(), p.z()},
                          {n.x(), n.y(), n.z()},
                          static_cast<float>(mesh.parts[triangle.part].albedo),
                          static_cast<GLuint>(triangle.part + 1)});
    }
  }
  return vertices;
}

// The pixels of the image that a target can touch: its projected bounding box, one pixel wider.
cv::Rect touched_pixels(const Scene& scene) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& vertex : scene.target->mesh.vertices) {
    box.extend(*project(scene.camera, scene.cam_from_target * vertex));
  }
  const auto limit = [](double x, int size) {
    return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(size)));
  };
  const int left = limit(std::floor(box.min().x()) - 1, scene.camera.width_px);
  const int top = limit(std::floor(box.min().y()) - 1, scene.camera.height_px);
  const int right = limit(std::ceil(box.max().x()) + 2, scene.camera.width_px);
  const int bottom = limit(std::ceil(box.max().y()) + 2, scene.camera.height_px);
  return {left, top, std::max(0, right - left), std::max(0, bottom - top)};
}

// z range of the target in the camera's frame, with room for rounding.
std::pair<double, double> depth_range(const Scene& scene) {
  double near_m = std::numeric_limits<double>::infinity();
  double far_m = 0;
  for (const Eigen::Vector3d& vertex : scene.target->mesh.vertices) {
    const double z = (scene.cam_from_target * vertex).z();
    near_m = std::min(near_m, z);
    far_m = std::max(far_m, z);
  }
  const double margin_m = 1e-3 * (far_m - near_m) + 1e-6 * far_m;
  return {std::max(near_m - margin_m, 1e-3 * near_m), far_m + margin_m};
}

// Clip coordinates of a tile of the image. Image v (down) goes to window y (up), so that the first
// row read back is the image's top row; the winding is mirrored with it. Pixel (0,0)'s centre, an
// integer, is window coordinate 0.5. Built in double, cast once.
Eigen::Matrix4f clip_from_target(const Scene& scene, const cv::Rect& tile) {
  const Camera& camera = scene.camera;
  const auto [near_m, far_m] = depth_range(scene);
  Eigen::Matrix4d clip_from_cam = Eigen::Matrix4d::Zero();
  clip_from_cam(0, 0) = 2 * camera.fx_px / tile.width;
  clip_from_cam(0, 2) = 2 * (camera.cx_px + 0.5 - tile.x) / tile.width - 1;
  clip_from_cam(1, 1) = 2 * camera.fy_px / tile.height;
  clip_from_cam(1, 2) = 2 * (camera.cy_px + 0.5 - tile.y) / tile.height - 1;
  clip_from_cam(2, 2) = (far_m + near_m) / (far_m - near_m);
  clip_from_cam(2, 3) = -2 * far_m * near_m / (far_m - near_m);
  clip_from_cam(3, 2) = 1;
  Eigen::Matrix4d cam_from_target = Eigen::Matrix4d::Identity();
  cam_from_target.topLeftCorner<3, 3>() = scene.cam_from_target.rotation;
  cam_from_target.topRightCorner<3, 1>() = scene.cam_from_target.translation;
  return (clip_from_cam * cam_from_target).cast<float>();
}

int samples_per_side(const Scene& scene) {
  return static_cast<int>(std::lround(std::sqrt(scene.samples_per_pixel)));
}

void require_imageable(const Scene& scene) {
  const std::string reason = why_not_imageable(scene);
  if (!reason.empty()) throw InputError(scene.target->name + ": " + reason);
  if (!scene.camera.distortion.is_zero()) {
    throw InputError("camera: the renderer draws pinhole cameras only; set distortion to zero");
  }
}

std::vector<FeatureTruth> feature_truths(const Scene& scene) {
  std::vector<FeatureTruth> truths;
  for (const TargetFeature& feature : scene.target->features) {
    FeatureTruth truth;
    const auto pixel = project(scene.camera, scene.cam_from_target * feature.position_m);
    if (pixel) {
      truth.pixel = *pixel;
      truth.is_in_image = is_inside(scene.camera, *pixel);
      truth.is_visible =
          truth.is_in_image && !is_self_hidden(*scene.target, feature, scene.cam_from_target);
    }
    truths.push_back(truth);
  }
  return truths;
}

// Sums of `side` x `side` samples, scaled to 1 = white.
void box_filter(const std::vector<uint16_t>& samples, int side, cv::Mat pixels) {
  const float scale = 1.0f / (65535.0f * static_cast<float>(side * side));
  const size_t stride = static_cast<size_t>(pixels.cols) * side;
  std::vector<uint32_t> sums(pixels.cols);
  for (int v = 0; v < pixels.rows; ++v) {
    std::fill(sums.begin(), sums.end(), 0);
    for (int row = 0; row < side; ++row) {
      const uint16_t* sample = samples.data() + (static_cast<size_t>(v) * side + row) * stride;
      for (int u = 0; u < pixels.cols; ++u) {
        for (int i = 0; i < side; ++i) sums[u] += *sample++;
      }
    }
    float* out = pixels.ptr<float>(v);
    for (int u = 0; u < pixels.cols; ++u) out[u] = static_cast<float>(sums[u]) * scale;
  }
}

}  // namespace

struct Renderer::Impl {
  // A framebuffer and what it draws into; renderbuffers grow, never shrink.
  struct Framebuffer {
    GLuint framebuffer = 0;
    GLuint depth = 0;
    std::vector<GLuint> colours;
    int width = 0;
    int height = 0;
  };

  struct MeshBuffer {
    std::shared_ptr<const Target> target;  // keeps the mesh's identity alive
    GLuint vertex_array = 0;
    GLuint buffer = 0;
    GLsizei vertex_count = 0;
  };

  Impl() : context(make_osmesa_context()), gl(load_gl_functions(*context)) {
    image_program = link(kImageShader);
    truth_program = link(kTruthShader);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    gl.FrontFace(GL_CW);  // clip_from_target mirrors
  }

  ~Impl() {
    try {
      context->make_current();
    } catch (const GraphicsError&) {
      return;  // without a current context there is nothing to release
    }
    for (Framebuffer* buffer : {&image_buffer, &truth_buffer}) release(*buffer);
    release(mesh);
    gl.DeleteProgram(image_program);
    gl.DeleteProgram(truth_program);
  }

  GLuint compile(GLenum stage, const char* source) {
    const GLuint shader = gl.CreateShader(stage);
    gl.ShaderSource(shader, 1, &source, nullptr);
    gl.CompileShader(shader);
    GLint compiled = 0;
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled == 0) {
      char log[2048] = {};
      gl.GetShaderInfoLog(shader, sizeof log, nullptr, log);
      throw GraphicsError(fmt::format("shader does not compile: {}", log));
    }
    return shader;
  }

  GLuint link(const char* fragment_source) {
    const GLuint vertex = compile(GL_VERTEX_SHADER, kVertexShader);
    const GLuint fragment = compile(GL_FRAGMENT_SHADER, fragment_source);
    const GLuint program = gl.CreateProgram();
    gl.AttachShader(program, vertex);
    gl.AttachShader(program, fragment);
    gl.LinkProgram(program);
    gl.DeleteShader(vertex);
    gl.DeleteShader(fragment);
    GLint linked = 0;
    gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked == 0) {
      char log[2048] = {};
      gl.GetProgramInfoLog(program, sizeof log, nullptr, log);
      throw GraphicsError(fmt::format("program does not link: {}", log));
    }
    return program;
  }

  void release(Framebuffer& buffer) {
    if (buffer.framebuffer == 0) return;
    gl.DeleteFramebuffers(1, &buffer.framebuffer);
    gl.DeleteRenderbuffers(1, &buffer.depth);
    gl.DeleteRenderbuffers(static_cast<GLsizei>(buffer.colours.size()), buffer.colours.data());
    buffer = {};
  }

  void release(MeshBuffer& buffer) {
    if (buffer.vertex_array == 0) return;
    gl.DeleteVertexArrays(1, &buffer.vertex_array);
    gl.DeleteBuffers(1, &buffer.buffer);
    buffer = {};
  }

  GLuint attach(GLenum format, GLenum attachment, int width, int height) {
    GLuint renderbuffer = 0;
    gl.GenRenderbuffers(1, &renderbuffer);
    gl.BindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
    gl.RenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, renderbuffer);
    return renderbuffer;
  }

  // Binds a framebuffer of at least width x height with these colour formats.
  void bind(Framebuffer& buffer, int width, int height, const std::vector<GLenum>& formats) {
    if (buffer.width >= width && buffer.height >= height) {
      gl.BindFramebuffer(GL_FRAMEBUFFER, buffer.framebuffer);
      gl.Viewport(0, 0, width, height);
      return;
    }
    const int new_width = std::max(width, buffer.width);
    const int new_height = std::max(height, buffer.height);
    release(buffer);
    gl.GenFramebuffers(1, &buffer.framebuffer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, buffer.framebuffer);
    std::vector<GLenum> attachments;
    for (size_t i = 0; i < formats.size(); ++i) {
      attachments.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i));
      buffer.colours.push_back(attach(formats[i], attachments.back(), new_width, new_height));
    }
    buffer.depth = attach(GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT, new_width, new_height);
    gl.DrawBuffers(static_cast<GLsizei>(attachments.size()), attachments.data());
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      throw GraphicsError(fmt::format("no framebuffer of {} x {}", new_width, new_height));
    }
    buffer.width = new_width;
    buffer.height = new_height;
    gl.Viewport(0, 0, width, height);
  }

  void upload(const std::shared_ptr<const Target>& target) {
    if (mesh.target == target) {
      gl.BindVertexArray(mesh.vertex_array);
      return;
    }
    release(mesh);
    const std::vector<Vertex> vertices = vertices_of(target->mesh);
    gl.GenVertexArrays(1, &mesh.vertex_array);
    gl.BindVertexArray(mesh.vertex_array);
    gl.GenBuffers(1, &mesh.buffer);
    gl.BindBuffer(GL_ARRAY_BUFFER, mesh.buffer);
    gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
                  vertices.data(), GL_STATIC_DRAW);
    const auto offset = [](size_t bytes) { return reinterpret_cast<const void*>(bytes); };
    constexpr GLsizei kStride = sizeof(Vertex);
    gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(Vertex, position)));
    gl.VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(Vertex, normal)));
    gl.VertexAttribPointer(2, 1, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(Vertex, albedo)));
    gl.VertexAttribIPointer(3, 1, GL_UNSIGNED_INT, kStride, offset(offsetof(Vertex, part_id)));
    for (GLuint i = 0; i < 4; ++i) gl.EnableVertexAttribArray(i);
    mesh.target = target;
    mesh.vertex_count = static_cast<GLsizei>(vertices.size());
  }

  void set_matrix(GLuint program, const char* name, const Eigen::Matrix4f& value) {
    gl.UniformMatrix4fv(gl.GetUniformLocation(program, name), 1, GL_FALSE, value.data());
  }

  void draw_image_tile(const Scene& scene, const cv::Rect& tile, cv::Mat pixels) {
    const int side = samples_per_side(scene);
    bind(image_buffer, tile.width * side, tile.height * side, {GL_R16});
    const float background[4] = {static_cast<float>(scene.background.level), 0, 0, 0};
    const float far_depth = 1;
    gl.ClearBufferfv(GL_COLOR, 0, background);
    gl.ClearBufferfv(GL_DEPTH, 0, &far_depth);
    gl.UseProgram(image_program);
    set_matrix(image_program, "clip_from_target", clip_from_target(scene, tile));
    const Eigen::Vector3f to_light =
        (scene.cam_from_target.rotation.transpose() * scene.light.to_light_in_cam).cast<float>();
    gl.Uniform3fv(gl.GetUniformLocation(image_program, "to_light"), 1, to_light.data());
    gl.Uniform1f(gl.GetUniformLocation(image_program, "ambient"),
                 static_cast<float>(scene.light.ambient));
    gl.Uniform1f(gl.GetUniformLocation(image_program, "directional"),
                 static_cast<float>(scene.light.directional));
    upload(scene.target);
    gl.DrawArrays(GL_TRIANGLES, 0, mesh.vertex_count);
    samples.resize(static_cast<size_t>(tile.area()) * side * side);
    gl.ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl.ReadPixels(0, 0, tile.width * side, tile.height * side, GL_RED, GL_UNSIGNED_SHORT,
                  samples.data());
    check_error();
    box_filter(samples, side, pixels);
  }

  // Depth minus that of the target's origin (R32F keeps micrometres so) and part ids.
  void draw_truth_tile(const Scene& scene, const cv::Rect& tile, cv::Mat relative_depth,
                       cv::Mat ids) {
    bind(truth_buffer, tile.width, tile.height, {GL_R32F, GL_R16UI});
    const float zero[4] = {};
    const GLuint none[4] = {};
    const float far_depth = 1;
    gl.ClearBufferfv(GL_COLOR, 0, zero);
    gl.ClearBufferuiv(GL_COLOR, 1, none);
    gl.ClearBufferfv(GL_DEPTH, 0, &far_depth);
    gl.UseProgram(truth_program);
    set_matrix(truth_program, "clip_from_target", clip_from_target(scene, tile));
    Eigen::Vector4f depth_row = Eigen::Vector4f::Zero();
    depth_row.head<3>() = scene.cam_from_target.rotation.row(2).transpose().cast<float>();
    gl.Uniform4fv(gl.GetUniformLocation(truth_program, "relative_depth"), 1, depth_row.data());
    upload(scene.target);
    gl.DrawArrays(GL_TRIANGLES, 0, mesh.vertex_count);
    gl.ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl.ReadPixels(0, 0, tile.width, tile.height, GL_RED, GL_FLOAT, relative_depth.data);
    gl.ReadBuffer(GL_COLOR_ATTACHMENT1);
    gl.ReadPixels(0, 0, tile.width, tile.height, GL_RED_INTEGER, GL_UNSIGNED_SHORT, ids.data);
    check_error();
  }

  void check_error() {
    const GLenum error = gl.GetError();
    if (error != GL_NO_ERROR) throw GraphicsError(fmt::format("OpenGL error 0x{:x}", error));
  }

  template <typename Draw>
  static void for_each_tile(const cv::Rect& area, int samples_a_side, const Draw& draw) {
    const int step = kMaxTileSamples / samples_a_side;
    for (int y = area.y; y < area.br().y; y += step) {
      for (int x = area.x; x < area.br().x; x += step) {
        draw(cv::Rect(x, y, std::min(step, area.br().x - x), std::min(step, area.br().y - y)));
      }
    }
  }

  cv::Mat linear(const Scene& scene) {
    context->make_current();
    cv::Mat image(scene.camera.height_px, scene.camera.width_px, CV_32F,
                  cv::Scalar(scene.background.level));
    for_each_tile(touched_pixels(scene), samples_per_side(scene),
                  [&](const cv::Rect& tile) { draw_image_tile(scene, tile, image(tile)); });
    return image;
  }

  // part_ids, and depth_m where it is wanted.
  void truth(const Scene& scene, cv::Mat& part_ids, cv::Mat* depth_m) {
    context->make_current();
    const cv::Size size(scene.camera.width_px, scene.camera.height_px);
    part_ids = cv::Mat::zeros(size, CV_16U);
    if (depth_m != nullptr) *depth_m = cv::Mat::zeros(size, CV_64F);
    const double z0_m = scene.cam_from_target.translation.z();
    for_each_tile(touched_pixels(scene), 1, [&](const cv::Rect& tile) {
      cv::Mat relative(tile.size(), CV_32F);
      cv::Mat ids(tile.size(), CV_16U);
      draw_truth_tile(scene, tile, relative, ids);
      ids.copyTo(part_ids(tile));
      if (depth_m == nullptr) return;
      cv::Mat depth;
      relative.convertTo(depth, CV_64F);
      depth += z0_m;
      depth.copyTo((*depth_m)(tile), ids != 0);
    });
  }

  std::unique_ptr<GlContext> context;
  GlFunctions gl;
  GLuint image_program = 0;
  GLuint truth_program = 0;
  Framebuffer image_buffer;
  Framebuffer truth_buffer;
  MeshBuffer mesh;
  std::vector<uint16_t> samples;
};

Renderer::Renderer() : impl_(std::make_unique<Impl>()) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Frame Renderer::render(const Scene& scene, RandomStream noise) {
  require_imageable(scene);
  Frame frame;
  frame.image = expose(impl_->linear(scene), scene.sensor, noise);
  impl_->truth(scene, frame.part_ids, &frame.depth_m);
  frame.truth.camera = scene.camera;
  BodyTruth& target = frame.truth.bodies.emplace_back();
  target.cam_from_target = scene.cam_from_target;
  target.features = feature_truths(scene);
  const cv::Mat covered = frame.part_ids != 0;
  frame.body_ids = covered / 255;
  target.visible_box = cv::boundingRect(covered);
  target.visible_pixels = cv::countNonZero(covered);
  return frame;
}

cv::Mat Renderer::render_linear(const Scene& scene) {
  require_imageable(scene);
  return impl_->linear(scene);
}

cv::Mat Renderer::render_part_ids(const Scene& scene) {
  require_imageable(scene);
  cv::Mat part_ids;
  impl_->truth(scene, part_ids, nullptr);
  return part_ids;
}

std::string Renderer::description() const {
  impl_->context->make_current();
  const auto text = [this](GLenum name) {
    const auto* value = reinterpret_cast<const char*>(impl_->gl.GetString(name));
    return std::string(value == nullptr ? "unknown" : value);
  };
  return fmt::format("{}: {}, {}", impl_->context->name(), text(GL_RENDERER), text(GL_VERSION));
}

}  // namespace sightline
