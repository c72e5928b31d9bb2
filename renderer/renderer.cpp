// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/renderer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/LU>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "renderer/background.h"
#include "renderer/colour_resolver.h"
#include "renderer/gl_painter.h"
#include "renderer/screen.h"
#include "renderer/sensor.h"
#include "renderer/shading.h"
#include "renderer/truth.h"
#include "renderer/views.h"
#include "scenes/files/input_error.h"
#include "scenes/mesh/mesh_soup.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

class Stopwatch {
 public:
  // Milliseconds since the last lap.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

void require_imageable(const Scene& scene) {
  const std::string reason = why_not_imageable(scene);
  if (!reason.empty()) throw InputError(scene.target->name + ": " + reason);
}

std::vector<Shader> shaders_of(const std::vector<PlacedBody>& bodies, const Scene& scene,
                               SkyMemory& skies) {
  std::vector<Shader> shaders;
  for (size_t b = 0; b < bodies.size(); ++b) {
    shaders.emplace_back(bodies[b], scene.light, shadow_on(bodies, b, scene), skies.of(b));
  }
  return shaders;
}

bool sends_light(const Mesh& mesh, bool draws_textures) {
  return std::any_of(mesh.parts.begin(), mesh.parts.end(), [&](const Part& part) {
    return part.material && (emission(*part.material, draws_textures) > 0).any();
  });
}

// Textures, colours of vertices or light of its own.
bool has_paint(const Scene& scene) {
  const bool draws_textures = scene.colouring.draws_textures;
  const auto is_painted = [&](const Mesh& mesh) {
    return (draws_textures && !mesh.coats.empty()) || sends_light(mesh, draws_textures);
  };
  return is_painted(scene.target->mesh) ||
         std::any_of(scene.others.begin(), scene.others.end(),
                     [&](const OtherBody& other) { return is_painted(other.target->mesh); });
}

// Grey surfaces alone are drawn as they always were.
bool needs_colour(const Scene& scene) {
  const Colouring& colouring = scene.colouring;
  return colouring.mode != ColourMode::kGrey || scene.environment.is_there() ||
         !scene.lamps.empty() || has_paint(scene);
}

cv::Mat to_grey(const cv::Mat& blue_green_red) {
  cv::Mat grey;
  cv::transform(blue_green_red, grey,
                cv::Matx13d(kLuminanceShares[2], kLuminanceShares[1], kLuminanceShares[0]));
  return grey;
}

// The picture of blue, green and red light where each has its own: a channel of each, or its share
// of grey.
cv::Mat joined(const std::array<cv::Mat, 3>& blue_green_red) {
  if (blue_green_red[0].channels() == 1) {
    return kLuminanceShares[2] * blue_green_red[0] + kLuminanceShares[1] * blue_green_red[1] +
           kLuminanceShares[0] * blue_green_red[2];
  }
  cv::Mat all = blue_green_red[1].clone();
  for (const int channel : {0, 2}) {
    cv::mixChannels(blue_green_red[static_cast<size_t>(channel)], all, {channel, channel});
  }
  return all;
}

// Turns what samples see into light.
class Resolver {
 public:
  Resolver(const std::vector<PlacedBody>& bodies, const Scene& scene, const Screen& screen,
           const SamplePattern& pattern, SkyMemory& skies)
      : bodies_(bodies),
        camera_(scene.camera),
        screen_(screen),
        pattern_(pattern),
        shaders_(shaders_of(bodies, scene, skies)) {}

  // The mean of one pixel's samples; where they see nothing it is `background`.
  float mean(int x, int y, const uint32_t* ids, float background) {
    enter_pixel(x, y);
    double sum = 0;
    int known = 0;  // entries of seen_
    for (int k = 0; k < pattern_.count; ++k) {
      const uint32_t id = ids[k];
      if (id == 0) {
        sum += background;
        continue;
      }
      if (k > 0 && id == ids[k - 1] && !seen_[known - 1].has_detail) {
        sum += seen_[known - 1].grey;
        continue;
      }
      const auto end = seen_.begin() + known;
      auto entry = std::find_if(seen_.begin(), end, [id](const Seen& s) { return s.id == id; });
      if (entry == end || entry->has_detail) {
        *end = shade(id, k, entry == end ? nullptr : &*entry);
        entry = end;
        ++known;
      } else if (entry + 1 != end) {
        std::iter_swap(entry, end - 1);  // the last is looked at first
        entry = end - 1;
      }
      sum += entry->grey;
    }
    return static_cast<float>(sum / pattern_.count);
  }

 private:
  struct Seen {
    uint32_t id = 0;
    bool has_detail = false;
    double grey = 0;
    double sky = 1;  // that of the first sample that sees it: it changes slowly
  };

  void enter_pixel(int x, int y) {
    centre_ = screen_.normalised({static_cast<double>(x), static_cast<double>(y)});
    per_pixel_ = Eigen::Vector2d(1 / camera_.fx_px, 1 / camera_.fy_px).asDiagonal();
    if (is_straight(camera_)) return;
    // Within a pixel the lens is its derivative: off by some 1e-4 px.
    per_pixel_ = per_pixel_ * lens_jacobian(camera_, centre_).inverse();
  }

  // `before` is the same surface as an earlier sample sees it.
  Seen shade(uint32_t id, int sample, const Seen* before) const {
    const size_t b = body_of(bodies_, id);
    const Shader& shader = shaders_[b];
    const Eigen::Vector2d offset(pattern_.x[sample], pattern_.y[sample]);
    const SurfacePoint point =
        shader.hits().on(static_cast<int>(id - bodies_[b].first_id), centre_ + per_pixel_ * offset);
    const double sky = before != nullptr ? before->sky : shader.sky_share(point);
    return {id, shader.has_detail(), std::min(1.0, shader.grey(point, sample, sky)), sky};
  }

  const std::vector<PlacedBody>& bodies_;
  const Camera& camera_;
  const Screen& screen_;
  const SamplePattern& pattern_;
  std::vector<Shader> shaders_;
  Eigen::Vector2d centre_;     // of the pixel, normalised
  Eigen::Matrix2d per_pixel_;  // its derivative by the pixel
  std::vector<Seen> seen_ = std::vector<Seen>(pattern_.count);
};

float mean_of(Resolver& resolver, int x, int y, const uint32_t* ids, float background) {
  return resolver.mean(x, y, ids, background);
}

cv::Vec3f mean_of(ColourResolver& resolver, int x, int y, const uint32_t* ids,
                  const cv::Vec3f& background) {
  const Eigen::Array3f rgb =
      resolver.mean(x, y, ids, {background[2], background[1], background[0]});
  return {rgb[2], rgb[1], rgb[0]};
}

bool shows_environment(const Scene& scene) {
  return scene.background.kind == BackgroundKind::kEnvironment && scene.environment.is_there();
}

// Adds a view's image to the sum: of a rolling shutter each row by its share.
void add_rows(const View& view, const Scene& scene, const cv::Mat& image, cv::Mat& sum) {
  if (!is_rolling(scene)) {
    if (sum.empty()) {
      sum = image;
    } else {
      sum += image;
    }
    return;
  }
  if (sum.empty()) sum = cv::Mat::zeros(image.size(), image.type());
  for (int row = 0; row < image.rows; ++row) {
    const double share = share_of(view, scene, row, image.rows);
    if (share > 0) sum.row(row) += share * image.row(row);
  }
}

}  // namespace

struct Renderer::Impl {
  explicit Impl(const RendererOptions& options)
      : painter(options.gl == GlChoice::kNone ? make_own_painter() : make_gl_painter(options.gl)) {}

  // Draws the scene's bodies, the main target at `cam_from_target`, over what the image holds.
  void draw(const Scene& scene, const Pose& cam_from_target, cv::Mat image) {
    Stopwatch watch;
    const std::vector<PlacedBody> bodies = placed_bodies(scene, cam_from_target);
    const Screen screen(scene.camera, {0, 0, image.cols, image.rows},
                        reference_depth_m(scene.target->mesh, scene.cam_from_target));
    on_screen.clear();
    for (const PlacedBody& body : bodies) {
      screen.append(*body.mesh, body.cam_from_body, body.first_id, on_screen);
    }
    const SamplePattern& pattern = sample_pattern(scene.samples_per_pixel);
    painter->start(on_screen, touched_box(on_screen, screen.canvas()), pattern);
    times.draw_ms += watch.lap();
    if (image.channels() == 1) {
      Resolver resolver(bodies, scene, screen, pattern, colours.skies);
      resolve<float>(resolver, pattern, watch, image);
    } else {
      ColourResolver resolver(bodies, scene, screen, pattern, colours);
      if (resolver.is_see_through()) {
        own_painter->start(on_screen, touched_box(on_screen, screen.canvas()), pattern);
        resolve_layers(resolver, pattern, watch, image);
      } else {
        resolve<cv::Vec3f>(resolver, pattern, watch, image);
      }
    }
  }

  // Gives every pixel that the painter touches the mean of its samples over what the image holds.
  template <typename Pixel, typename AnyResolver>
  void resolve(AnyResolver& resolver, const SamplePattern& pattern, Stopwatch& watch,
               cv::Mat& image) {
    times.resolve_ms += watch.lap();
    while (painter->next(strip)) {
      times.readback_ms += strip.readback_ms;
      times.draw_ms += watch.lap() - strip.readback_ms;
      for (int y = strip.box.top; y < strip.box.bottom; ++y) {
        Pixel* row = image.ptr<Pixel>(y);
        for (int x = strip.box.left; x < strip.box.right; ++x) {
          const size_t pixel = strip.pixel(x, y);
          if (!strip.is_touched[pixel]) continue;
          row[x] = mean_of(resolver, x, y, strip.ids.data() + pixel * pattern.count, row[x]);
        }
      }
      times.resolve_ms += watch.lap();
    }
  }

  // The same where pixels are made of layers. A surface behind kMostLayers others is not seen.
  void resolve_layers(ColourResolver& resolver, const SamplePattern& pattern, Stopwatch& watch,
                      cv::Mat& image) {
    constexpr int kMostLayers = 32;
    const auto count = static_cast<size_t>(pattern.count);
    while (own_painter->next(strip)) {
      std::vector<uint8_t> was_touched = strip.is_touched;
      samples.assign(was_touched.size() * count, Eigen::Array4f(0, 0, 0, 1));
      for (int layer = 0; layer < kMostLayers; ++layer) {
        if (layer > 0) own_painter->paint_behind(strip);
        if (!add_layer(resolver, count)) break;
      }
      for_each_touched(was_touched, [&](int x, int y, size_t pixel) {
        cv::Vec3f& to = image.at<cv::Vec3f>(y, x);
        const Eigen::Array3f rgb =
            resolver.mean(samples.data() + pixel * count, {to[2], to[1], to[0]});
        to = {rgb[2], rgb[1], rgb[0]};
      });
    }
    times.resolve_ms += watch.lap();
  }

  // True when the layer, which the strip holds, lets something through.
  bool add_layer(ColourResolver& resolver, size_t count) {
    bool lets_through = false;
    for_each_touched(strip.is_touched, [&](int x, int y, size_t pixel) {
      const size_t at = pixel * count;
      lets_through |= resolver.add_layer(x, y, strip.ids.data() + at, strip.nearness.data() + at,
                                         samples.data() + at);
    });
    return lets_through;
  }

  template <typename Visit>
  void for_each_touched(const std::vector<uint8_t>& is_touched, const Visit& visit) {
    for (int y = strip.box.top; y < strip.box.bottom; ++y) {
      for (int x = strip.box.left; x < strip.box.right; ++x) {
        const size_t pixel = strip.pixel(x, y);
        if (is_touched[pixel]) visit(x, y, pixel);
      }
    }
  }

  cv::Mat background_of(const Scene& scene) {
    const cv::Size size(scene.camera.width_px, scene.camera.height_px);
    if (shows_environment(scene)) {
      return environment_image(*colours.environment_of(scene), scene.environment, scene.camera);
    }
    return needs_colour(scene) ? colour_background_image(scene.background, size)
                               : background_image(scene.background, size);
  }

  // The light of a scene, as its channels are drawn.
  cv::Mat averaged(const Scene& scene) {
    const int views = view_count(scene);
    const cv::Mat background = background_of(scene);
    const bool moves_background = scene.optics.has_aperture() && shows_environment(scene);
    colours.skies.turn_to(scene);
    cv::Mat sum;
    for (int i = 0; i < views; ++i) {
      const View view = view_at(scene, i);
      cv::Mat image = moves_background ? background_of(view.scene) : background.clone();
      draw(view.scene, view.cam_from_target, image);
      add_rows(view, scene, image, sum);
    }
    return views == 1 || is_rolling(scene) ? sum : sum / views;
  }

  cv::Mat linear(const Scene& scene) {
    cv::Mat light = averaged(scene);
    const Optics& optics = scene.optics;
    if (optics.has_chromatic_shift()) {
      const auto of_scale = [&](double part) {
        if (part == 0) return light;
        Scene other = scene;
        other.camera = scaled(scene.camera, part);
        return averaged(other);
      };
      light = joined({of_scale(optics.blue_scale), light, of_scale(optics.red_scale)});
    }
    const bool is_painted_grey = light.channels() == 3 && scene.colouring.mode == ColourMode::kGrey;
    return is_painted_grey ? to_grey(light) : light;
  }

  std::unique_ptr<SamplePainter> painter;
  std::unique_ptr<SamplePainter> own_painter = make_own_painter();  // of what is see-through
  // Kept between frames for their memory.
  ScreenMesh on_screen;
  VisibleStrip strip;
  ColourMemory colours;
  std::vector<Eigen::Array4f> samples;  // of a strip that is made of layers
  DrawTimes times;
};

Renderer::Renderer(const RendererOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Frame Renderer::render(const Scene& scene, RandomStream noise) {
  require_imageable(scene);
  Frame frame;
  const bool is_mosaic = scene.colouring.mode == ColourMode::kBayer;
  cv::Mat exposed = is_mosaic ? expose_mosaic(impl_->linear(scene), scene.sensor, noise)
                              : expose(impl_->linear(scene), scene.sensor, noise);
  std::string jpeg;
  if (scene.sensor.jpeg_quality > 0) {
    jpeg = jpeg_bytes(exposed, scene.sensor.jpeg_quality);
    exposed = decode_picture(jpeg).pixels;
  }
  if (exposed.channels() == 3) {
    frame.colour = exposed;
    frame.colour_jpeg = std::move(jpeg);
    cv::cvtColor(exposed, frame.image, cv::COLOR_BGR2GRAY);
  } else {
    frame.image = exposed;
  }
  Stopwatch watch;
  state_truth(scene, impl_->colours.textures, frame);
  impl_->times.truth_ms += watch.lap();
  return frame;
}

cv::Mat Renderer::render_linear(const Scene& scene) {
  require_imageable(scene);
  return impl_->linear(scene);
}

cv::Mat Renderer::render_part_ids(const Scene& scene) {
  require_imageable(scene);
  return part_ids_alone(scene);
}

std::string Renderer::description() const {
  return impl_->painter->description();
}

const DrawTimes& Renderer::times() const {
  return impl_->times;
}

}  // namespace sightline
