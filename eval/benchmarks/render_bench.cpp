// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// render/<samples a pixel>: a frame of a Boeing 707 (11 584 triangles, 512 x 512) as grey image,
// 16-bit depth and mask of bodies, each as PNG in memory, without sensor noise; a new pose each.
// Counters: milliseconds a frame by stage, and resident memory after the run.
// render/rgb/<samples>: a sphere (13 000 triangles) with a texture of 2048 x 2048 px in colour;
// render/rgb_grey/<samples>: the same in grey without the texture.
// render/osmesa/<samples>: the airliner with OpenGL in software in place of our rasteriser.
// render/embree/<samples>: the same by rays of Embree, in packets of 16, through the same samples;
// render/embree_rgb/<samples>: so the textured sphere, with a bilinear texel a sample.
#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <numbers>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>
#include <opencv2/core.hpp>
#include <unistd.h>

#include "eval/benchmarks/benches.h"
#include "renderer/renderer.h"
#include "renderer/sample_pattern.h"
#include "scenes/mesh/textures.h"
#include "scenes/picture/picture_file.h"
#include "scenes/target/target.h"

namespace sightline {
namespace {

constexpr int kBenchedSampleCounts[] = {1, 4, 16, 64};

Scene scene_of(int samples_per_pixel) {
  Scene scene;
  static const auto boeing = load_target("boeing707");
  scene.target = boeing;
  scene.cam_from_target.translation = {0, 0, 1150};
  scene.sensor.psf_sigma_px = 0;
  scene.sensor.read_noise_grey = 0;
  scene.samples_per_pixel = samples_per_pixel;
  return scene;
}

void turn(Scene& scene, int64_t frame) {
  RandomStream stream(1, "bench poses", frame % 64);
  scene.cam_from_target.rotation = stream.rotation();
}

// Squares of 32 texels in changing colours, with a little noise.
std::shared_ptr<const Texture> bench_texture() {
  Texture texture{.name = "bench", .width = 2048, .height = 2048, .rgba = {}};
  RandomStream stream(1, "bench texture", 0);
  for (int y = 0; y < texture.height; ++y) {
    for (int x = 0; x < texture.width; ++x) {
      const int noise = static_cast<int>(stream.bits() % 32);
      const int bright = ((x >> 5) ^ (y >> 5)) & 1;
      for (const int c : {60 + 130 * bright + noise, 90 + (x >> 5) + noise, 40 + noise, 255}) {
        texture.rgba.push_back(static_cast<uint8_t>(c));
      }
    }
  }
  return std::make_shared<const Texture>(std::move(texture));
}

// As far from the camera as the airliner: 213 px across.
std::shared_ptr<const Target> textured_sphere() {
  constexpr int kRows = 58, kColumns = 114;
  constexpr double kRadiusM = 12;
  Mesh mesh;
  const auto uv_of = [](int row, int column) {
    return Eigen::Vector2f(static_cast<float>(column) / kColumns, static_cast<float>(row) / kRows);
  };
  for (int row = 0; row <= kRows; ++row) {
    for (int column = 0; column <= kColumns; ++column) {
      const double polar = std::numbers::pi * row / kRows;
      const double around = 2 * std::numbers::pi * column / kColumns;
      mesh.vertices.push_back(kRadiusM * Eigen::Vector3d(std::sin(polar) * std::cos(around),
                                                         std::sin(polar) * std::sin(around),
                                                         std::cos(polar)));
    }
  }
  const auto add = [&](const std::array<std::pair<int, int>, 3>& corners) {
    Triangle triangle;
    Coat coat;
    for (size_t i = 0; i < 3; ++i) {
      const auto [row, column] = corners[i];
      triangle.vertex[i] = row * (kColumns + 1) + column;
      triangle.normal[i] = mesh.vertices[static_cast<size_t>(triangle.vertex[i])].normalized();
      coat.uv[i] = uv_of(row, column);
    }
    mesh.triangles.push_back(triangle);
    mesh.coats.push_back(coat);
  };
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      if (row > 0) add({{{row, column}, {row + 1, column}, {row, column + 1}}});
      if (row + 1 < kRows) add({{{row, column + 1}, {row + 1, column}, {row + 1, column + 1}}});
    }
  }
  Material material;
  material.base_texture.texture = 0;
  mesh.textures = {bench_texture()};
  mesh.parts = {{"sphere", 0.5, material}};
  Occluder occluder(mesh);
  return std::make_shared<const Target>(
      Target{"sphere", "", std::move(mesh), {}, {}, std::move(occluder)});
}

Scene textured_scene(int samples_per_pixel, bool is_rgb) {
  Scene scene = scene_of(samples_per_pixel);
  static const auto sphere = textured_sphere();
  scene.target = sphere;
  scene.colouring.mode = is_rgb ? ColourMode::kRgb : ColourMode::kGrey;
  scene.colouring.draws_textures = is_rgb;
  return scene;
}

size_t encode(const cv::Mat& image, const cv::Mat& depth_m, const cv::Mat& body_ids) {
  cv::Mat depth;
  depth_m.convertTo(depth, CV_16U, 50);
  size_t bytes = 0;
  for (const cv::Mat& picture : {image, depth, cv::Mat(body_ids != 0)}) {
    bytes += png_bytes(picture).size();
  }
  return bytes;
}

double resident_mb() {
  std::ifstream file("/proc/self/statm");
  long size = 0, resident = 0;
  file >> size >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

benchmark::Counter per_frame(double ms) {
  return {ms, benchmark::Counter::kAvgIterations};
}

double milliseconds_since(int64_t begin_ticks) {
  return static_cast<double>(cv::getTickCount() - begin_ticks) * 1e3 / cv::getTickFrequency();
}

void run_ours(benchmark::State& state, Scene scene, GlChoice gl) {
  std::unique_ptr<Renderer> renderer;
  try {
    renderer = std::make_unique<Renderer>(RendererOptions{.gl = gl});
  } catch (const GraphicsError& error) {
    state.SkipWithError(error.what());
    return;
  }
  // A renderer prepares each texture once, which a set of images pays with its first.
  renderer->render(scene, RandomStream(1, "sensor", 0));
  const auto before = renderer->times();
  double encode_ms = 0;
  int64_t frame = 0;
  for (auto _ : state) {
    turn(scene, frame++);
    const Frame drawn = renderer->render(scene, RandomStream(1, "sensor", frame));
    const int64_t begin = cv::getTickCount();
    const cv::Mat& picture = drawn.colour.empty() ? drawn.image : drawn.colour;
    benchmark::DoNotOptimize(encode(picture, drawn.depth_m, drawn.body_ids));
    encode_ms += milliseconds_since(begin);
  }
  state.counters["draw_ms"] = per_frame(renderer->times().draw_ms - before.draw_ms);
  state.counters["readback_ms"] = per_frame(renderer->times().readback_ms - before.readback_ms);
  state.counters["resolve_ms"] = per_frame(renderer->times().resolve_ms - before.resolve_ms);
  state.counters["truth_ms"] = per_frame(renderer->times().truth_ms - before.truth_ms);
  state.counters["encode_ms"] = per_frame(encode_ms);
  state.counters["resident_mb"] = resident_mb();
}

// A body in Embree, in its own frame.
class EmbreeBody {
 public:
  explicit EmbreeBody(const Mesh& mesh)
      : mesh_(mesh), device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
      for (int i = 0; i < 3; ++i) *vertices++ = static_cast<float>(vertex[i]);
    }
    auto* corners = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh.triangles.size()));
    for (const Triangle& triangle : mesh.triangles) {
      for (const int corner : triangle.vertex) *corners++ = static_cast<unsigned>(corner);
    }
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    rtcCommitScene(scene_);
  }
  EmbreeBody(const EmbreeBody&) = delete;
  EmbreeBody& operator=(const EmbreeBody&) = delete;
  ~EmbreeBody() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  // Up to 16 rays from one eye; `directions` in the body's frame.
  RTCRayHit16 cast(const Eigen::Vector3f& eye, const std::vector<Eigen::Vector3f>& directions) {
    RTCRayHit16 rays;
    alignas(64) int valid[16];
    for (size_t i = 0; i < 16; ++i) {
      valid[i] = i < directions.size() ? -1 : 0;
      const Eigen::Vector3f& d = directions[i < directions.size() ? i : 0];
      rays.ray.org_x[i] = eye.x();
      rays.ray.org_y[i] = eye.y();
      rays.ray.org_z[i] = eye.z();
      rays.ray.dir_x[i] = d.x();
      rays.ray.dir_y[i] = d.y();
      rays.ray.dir_z[i] = d.z();
      rays.ray.tnear[i] = 0;
      rays.ray.tfar[i] = std::numeric_limits<float>::infinity();
      rays.ray.time[i] = 0;
      rays.ray.mask[i] = ~0u;
      rays.ray.id[i] = static_cast<unsigned>(i);
      rays.ray.flags[i] = 0;
      rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, scene_, &context, &rays);
    return rays;
  }

  // The light on what ray i hits. As ours: the interpolated normal, lit like paper from either
  // side.
  float light_on(const RTCRayHit16& rays, int i, const Light& light,
                 const Eigen::Vector3f& to_light) const {
    const Triangle& triangle = mesh_.triangles[rays.hit.primID[i]];
    const float u = rays.hit.u[i], v = rays.hit.v[i];
    Eigen::Vector3f normal = (1 - u - v) * triangle.normal[0].cast<float>() +
                             u * triangle.normal[1].cast<float>() +
                             v * triangle.normal[2].cast<float>();
    const Eigen::Vector3f facing(rays.hit.Ng_x[i], rays.hit.Ng_y[i], rays.hit.Ng_z[i]);
    const Eigen::Vector3f ray(rays.ray.dir_x[i], rays.ray.dir_y[i], rays.ray.dir_z[i]);
    if (facing.dot(ray) > 0) normal = -normal;
    const float cosine = std::max(0.0f, normal.normalized().dot(to_light));
    return static_cast<float>(light.ambient + light.directional * cosine);
  }

  float albedo(const RTCRayHit16& rays, int i) const {
    return static_cast<float>(mesh_.parts[mesh_.triangles[rays.hit.primID[i]].part].albedo);
  }

  Eigen::Vector2f uv(const RTCRayHit16& rays, int i) const {
    const Coat& coat = mesh_.coats[rays.hit.primID[i]];
    const float u = rays.hit.u[i], v = rays.hit.v[i];
    return (1 - u - v) * coat.uv[0] + u * coat.uv[1] + v * coat.uv[2];
  }

 private:
  const Mesh& mesh_;
  RTCDevice device_;
  RTCScene scene_;
};

// A texture that repeats, as rays look it up: bilinear, in linear blue, green and red.
class BilinearTexture {
 public:
  explicit BilinearTexture(const Texture& texture) : texture_(texture) {
    for (size_t i = 0; i < linear_.size(); ++i) {
      linear_[i] = static_cast<float>(linear_from_srgb(static_cast<double>(i) / 255));
    }
  }

  cv::Vec3f at(const Eigen::Vector2f& uv) const {
    const float x = uv.x() * static_cast<float>(texture_.width) - 0.5F;
    const float y = uv.y() * static_cast<float>(texture_.height) - 0.5F;
    const float left = std::floor(x), top = std::floor(y);
    const float s = x - left, t = y - top;
    const int column = static_cast<int>(left), row = static_cast<int>(top);
    return (1 - t) * (1 - s) * texel(column, row) + (1 - t) * s * texel(column + 1, row) +
           t * (1 - s) * texel(column, row + 1) + t * s * texel(column + 1, row + 1);
  }

 private:
  cv::Vec3f texel(int column, int row) const {
    // Sides that are powers of two.
    const int x = column & (texture_.width - 1), y = row & (texture_.height - 1);
    const uint8_t* const rgba = &texture_.rgba[4 * (static_cast<size_t>(y) * texture_.width + x)];
    return {linear_[rgba[2]], linear_[rgba[1]], linear_[rgba[0]]};
  }

  const Texture& texture_;
  std::array<float, 256> linear_{};
};

// The pixels that the target can touch.
cv::Rect touched_pixels(const Scene& scene) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& vertex : scene.target->mesh.vertices) {
    box.extend(*project(scene.camera, scene.cam_from_target * vertex));
  }
  const cv::Rect touched(
      cv::Point(static_cast<int>(box.min().x()), static_cast<int>(box.min().y())),
      cv::Point(static_cast<int>(box.max().x()) + 2, static_cast<int>(box.max().y()) + 2));
  return touched & cv::Rect(0, 0, scene.camera.width_px, scene.camera.height_px);
}

struct EmbreeFrame {
  cv::Mat image, depth_m, body_ids;
};

// `shade` gives what ray i of some sees, given the light on it: a grey level or three colours.
template <typename Shade>
EmbreeFrame draw_with_embree(EmbreeBody& body, const Scene& scene, const Shade& shade) {
  using Value = std::invoke_result_t<Shade, const RTCRayHit16&, int, float>;
  constexpr int kChannels = Value::channels;
  const cv::Size size(scene.camera.width_px, scene.camera.height_px);
  cv::Mat linear(size, CV_32FC(kChannels), cv::Scalar::all(scene.background.level));
  EmbreeFrame frame{{}, cv::Mat::zeros(size, CV_64F), cv::Mat::zeros(size, CV_8U)};
  const SamplePattern& pattern = sample_pattern(scene.samples_per_pixel);
  const Eigen::Matrix3f turn = scene.cam_from_target.rotation.transpose().cast<float>();
  const Eigen::Vector3f eye = inverse(scene.cam_from_target).translation.cast<float>();
  const Eigen::Vector3f to_light = turn * scene.light.to_light_in_cam.cast<float>();
  const Value background = Value::all(static_cast<float>(scene.background.level));
  const auto direction = [&](double x, double y) -> Eigen::Vector3f {
    return turn * Eigen::Vector3d((x - scene.camera.cx_px) / scene.camera.fx_px,
                                  (y - scene.camera.cy_px) / scene.camera.fy_px, 1)
                      .cast<float>();
  };
  const cv::Rect box = touched_pixels(scene);
  std::vector<Eigen::Vector3f> directions;
  std::vector<int> columns;
  for (int y = box.y; y < box.br().y; ++y) {
    // A row's samples in order, by sixteen: whole pixels, parts of one or several.
    std::vector<Value> sums(box.width);
    const auto flush = [&] {
      if (directions.empty()) return;
      const RTCRayHit16 rays = body.cast(eye, directions);
      for (size_t i = 0; i < directions.size(); ++i) {
        const int ray = static_cast<int>(i);
        const bool is_hit = rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        sums[columns[i]] +=
            is_hit ? shade(rays, ray, body.light_on(rays, ray, scene.light, to_light)) : background;
      }
      directions.clear();
      columns.clear();
    };
    for (int x = 0; x < box.width; ++x) {
      for (int k = 0; k < pattern.count; ++k) {
        directions.push_back(direction(box.x + x + pattern.x[k], y + pattern.y[k]));
        columns.push_back(x);
        if (directions.size() == 16) flush();
      }
    }
    flush();
    for (int x = 0; x < box.width; ++x) {
      linear.at<Value>(y, box.x + x) = sums[x] * (1.0F / static_cast<float>(pattern.count));
    }
    // Depth and ids through the pixels' centres.
    for (int x = 0; x < box.width; x += 16) {
      for (int i = x; i < std::min(x + 16, box.width); ++i) {
        directions.push_back(direction(box.x + i, y));
      }
      const RTCRayHit16 rays = body.cast(eye, directions);
      for (size_t i = 0; i < directions.size(); ++i) {
        if (rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
        frame.depth_m.at<double>(y, box.x + x + static_cast<int>(i)) = rays.ray.tfar[i];
        frame.body_ids.at<uint8_t>(y, box.x + x + static_cast<int>(i)) = 1;
      }
      directions.clear();
    }
  }
  linear.convertTo(frame.image, CV_8U, 255);
  return frame;
}

// `draw` draws the scene with Embree.
template <typename Draw>
void run_embree(benchmark::State& state, Scene scene, const Draw& draw) {
  double encode_ms = 0;
  int64_t frame = 0;
  for (auto _ : state) {
    turn(scene, frame++);
    const EmbreeFrame drawn = draw(scene);
    const int64_t begin = cv::getTickCount();
    benchmark::DoNotOptimize(encode(drawn.image, drawn.depth_m, drawn.body_ids));
    encode_ms += milliseconds_since(begin);
  }
  // The peer must draw the same picture, or the comparison means nothing.
  turn(scene, 0);
  const Frame ours = Renderer().render(scene, RandomStream(1, "sensor", 0));
  const cv::Mat& picture = ours.colour.empty() ? ours.image : ours.colour;
  state.counters["differs_grey"] =
      cv::norm(picture, draw(scene).image, cv::NORM_L1) / (512.0 * 512.0 * picture.channels());
  state.counters["encode_ms"] = per_frame(encode_ms);
}

void run_embree_grey(benchmark::State& state, int samples_per_pixel) {
  const Scene scene = scene_of(samples_per_pixel);
  EmbreeBody body(scene.target->mesh);
  const auto shade = [&body](const RTCRayHit16& rays, int i, float light) {
    return cv::Vec<float, 1>(body.albedo(rays, i) * light);
  };
  run_embree(state, scene,
             [&](const Scene& turned) { return draw_with_embree(body, turned, shade); });
}

void run_embree_rgb(benchmark::State& state, int samples_per_pixel) {
  const Scene scene = textured_scene(samples_per_pixel, true);
  const Mesh& mesh = scene.target->mesh;
  EmbreeBody body(mesh);
  const BilinearTexture texture(*mesh.textures.front());
  const auto shade = [&](const RTCRayHit16& rays, int i, float light) {
    return texture.at(body.uv(rays, i)) * light;
  };
  run_embree(state, scene,
             [&](const Scene& turned) { return draw_with_embree(body, turned, shade); });
}

}  // namespace

PeerComparison register_render() {
  for (const int samples : kBenchedSampleCounts) {
    const std::string size = std::to_string(samples);
    const auto add = [](const std::string& name, const auto& run) {
      benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond);
    };
    add("render/" + size, [samples](benchmark::State& state) {
      run_ours(state, scene_of(samples), GlChoice::kNone);
    });
    for (const bool is_rgb : {true, false}) {
      add((is_rgb ? "render/rgb/" : "render/rgb_grey/") + size,
          [samples, is_rgb](benchmark::State& state) {
            run_ours(state, textured_scene(samples, is_rgb), GlChoice::kNone);
          });
    }
    add("render/osmesa/" + size, [samples](benchmark::State& state) {
      run_ours(state, scene_of(samples), GlChoice::kOsMesa);
    });
    add("render/embree/" + size,
        [samples](benchmark::State& state) { run_embree_grey(state, samples); });
    add("render/embree_rgb/" + size,
        [samples](benchmark::State& state) { run_embree_rgb(state, samples); });
  }
  return {"render", "", {"osmesa", "embree"}};
}

}  // namespace sightline
