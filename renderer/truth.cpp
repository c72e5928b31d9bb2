// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/truth.h"

#include <algorithm>
#include <limits>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "renderer/opacity.h"
#include "renderer/screen.h"

namespace sightline {
namespace {

PixelBox image_box(const Camera& camera) {
  return {0, 0, camera.width_px, camera.height_px};
}

// The image and as much again on every side.
PixelBox amodal_canvas(const Camera& camera) {
  return {-camera.width_px, -camera.height_px, 2 * camera.width_px, 2 * camera.height_px};
}

// What the centre of each pixel of a box sees.
struct IdImage {
  PixelBox box;
  std::vector<uint32_t> ids;  // row by row; 0 is nothing
};

// Finds what the pixels of a strip's rows see where surfaces are looked through: into `ids`, row by
// row, the nearest that lets nothing through; else the nearest that is seen at all.
void look_through(SamplePainter& painter, VisibleStrip& strip, const Screen& screen,
                  SurfaceOpacity& opacity, uint32_t* ids) {
  constexpr int kMostLayers = 32;  // as a picture has them
  std::fill_n(ids, strip.is_touched.size(), 0);
  for (int layer = 0; layer < kMostLayers; ++layer) {
    if (layer > 0) painter.paint_behind(strip);
    bool lets_through = false;
    for (size_t i = 0; i < strip.is_touched.size(); ++i) {
      const uint32_t id = strip.is_touched[i] ? strip.ids[i] : 0;
      if (id == 0) continue;
      const int width = strip.box.width();
      const Eigen::Vector2d pixel(strip.box.left + static_cast<int>(i) % width,
                                  strip.box.top + static_cast<int>(i) / width);
      const float covered = opacity.at(id, screen.normalised(pixel));
      const bool is_opaque = covered >= 1;
      if (is_opaque || (covered > 0 && ids[i] == 0)) ids[i] = id;
      if (is_opaque) strip.nearness[i] = -std::numeric_limits<float>::max();
      lets_through |= !is_opaque;
    }
    if (!lets_through) return;
  }
}

// Without `opacity` what is nearest is seen.
IdImage paint_ids(const std::vector<PlacedBody>& bodies, const Screen& screen,
                  SurfaceOpacity* opacity = nullptr) {
  ScreenMesh on_screen;
  for (const PlacedBody& body : bodies) {
    screen.append(*body.mesh, body.cam_from_body, body.first_id, on_screen);
  }
  IdImage image{touched_box(on_screen, screen.canvas()), {}};
  if (image.box.is_empty()) return image;
  image.ids.resize(static_cast<size_t>(image.box.width()) * image.box.height());
  const std::unique_ptr<SamplePainter> painter = make_own_painter();
  painter->start(on_screen, image.box, sample_pattern(1));
  VisibleStrip strip;
  while (painter->next(strip)) {
    const size_t first = static_cast<size_t>(strip.box.top - image.box.top) * image.box.width();
    const size_t count = static_cast<size_t>(strip.box.width()) * strip.box.height();
    if (opacity != nullptr) {
      look_through(*painter, strip, screen, *opacity, image.ids.data() + first);
      continue;
    }
    for (size_t i = 0; i < count; ++i) {
      image.ids[first + i] = strip.is_touched[i] ? strip.ids[i] : 0;
    }
  }
  return image;
}

template <typename Visit>
void for_each_seen(const IdImage& image, const Visit& visit) {
  const uint32_t* id = image.ids.data();
  for (int y = image.box.top; y < image.box.bottom; ++y) {
    for (int x = image.box.left; x < image.box.right; ++x, ++id) {
      if (*id != 0) visit(x, y, *id);
    }
  }
}

// Grows by pixels.
class Extent {
 public:
  void add(int x, int y) {
    left_ = std::min(left_, x);
    right_ = std::max(right_, x);
    top_ = std::min(top_, y);
    bottom_ = std::max(bottom_, y);
    ++count_;
  }
  int count() const { return count_; }
  cv::Rect box() const {
    if (count_ == 0) return {};
    return {left_, top_, right_ - left_ + 1, bottom_ - top_ + 1};
  }

 private:
  int left_ = INT32_MAX, right_ = INT32_MIN, top_ = INT32_MAX, bottom_ = INT32_MIN;
  int count_ = 0;
};

void state_pixels(const std::vector<PlacedBody>& bodies, const IdImage& image, const Screen& screen,
                  Frame& frame) {
  std::vector<RayHits> hits;
  for (const PlacedBody& body : bodies) hits.emplace_back(body);
  std::vector<Extent> seen(bodies.size());
  for_each_seen(image, [&](int x, int y, uint32_t id) {
    const size_t b = body_of(bodies, id);
    const int triangle = static_cast<int>(id - bodies[b].first_id);
    const SurfacePoint point =
        hits[b].on(triangle, screen.normalised({static_cast<double>(x), static_cast<double>(y)}));
    frame.depth_m.at<double>(y, x) = hits[b].depth_m(point);
    frame.part_ids.at<uint16_t>(y, x) =
        static_cast<uint16_t>(bodies[b].mesh->triangles[triangle].part + 1);
    frame.body_ids.at<uint8_t>(y, x) = static_cast<uint8_t>(b + 1);
    seen[b].add(x, y);
  });
  for (size_t b = 0; b < bodies.size(); ++b) {
    frame.truth.bodies[b].visible_box = seen[b].box();
    frame.truth.bodies[b].visible_pixels = seen[b].count();
  }
}

void state_amodal(const PlacedBody& body, const Screen& canvas, const Scene& scene,
                  TextureCache& textures, BodyTruth& truth) {
  const std::vector<PlacedBody> alone{body};
  SurfaceOpacity opacity(alone, scene.colouring.draws_textures, textures);
  const bool looks_through = scene.colouring.truth_sees == TruthSurface::kOpaque;
  Extent extent;
  const cv::Rect in_image(0, 0, truth.amodal_mask.cols, truth.amodal_mask.rows);
  const IdImage image = paint_ids(alone, canvas, looks_through ? &opacity : nullptr);
  for_each_seen(image, [&](int x, int y, uint32_t) {
    extent.add(x, y);
    if (in_image.contains({x, y})) truth.amodal_mask.at<uint8_t>(y, x) = 255;
  });
  truth.amodal_box = extent.box();
  truth.amodal_pixels = extent.count();
}

const Target& target_of(const Scene& scene, size_t body) {
  return body == 0 ? *scene.target : *scene.others[body - 1].target;
}

bool is_hidden_by(const Target& other, const Pose& cam_from_other,
                  const Eigen::Vector3d& x_in_cam) {
  const Pose other_from_cam = inverse(cam_from_other);
  return other.occluder.hides(other_from_cam * x_in_cam, other_from_cam.translation, 0);
}

std::vector<EdgeTruth> edge_truths(const Camera& camera, const Pose& cam_from_target,
                                   const TargetFeature& feature) {
  std::vector<EdgeTruth> truths;
  if (feature.kind != FeatureKind::kLineIntersection) return truths;
  for (const Edge& edge : feature.edges) {
    const Eigen::Vector3d begin = cam_from_target * edge.begin_m;
    Eigen::Vector3d end = cam_from_target * edge.end_m;
    // The feature itself is in front; an edge that is not is cut just before the camera's plane.
    const double least_z = 1e-3 * begin.z();
    if (end.z() < least_z) {
      end = begin + (end - begin) * ((begin.z() - least_z) / (begin.z() - end.z()));
    }
    truths.push_back({*project(camera, begin), *project(camera, end)});
  }
  return truths;
}

FeatureTruth feature_truth(const Scene& scene, const std::vector<PlacedBody>& bodies, size_t body,
                           const TargetFeature& feature) {
  FeatureTruth truth;
  const Pose& cam_from_target = bodies[body].cam_from_body;
  const Eigen::Vector3d x_in_cam = cam_from_target * feature.position_m;
  const auto pixel = project(scene.camera, x_in_cam);
  if (!pixel) return truth;
  truth.pixel = *pixel;
  truth.is_in_image = is_inside(scene.camera, *pixel);
  for (size_t other = 0; other < bodies.size() && !truth.is_hidden_by_other; ++other) {
    truth.is_hidden_by_other = other != body && is_hidden_by(target_of(scene, other),
                                                             bodies[other].cam_from_body, x_in_cam);
  }
  truth.is_visible = truth.is_in_image && !truth.is_hidden_by_other &&
                     !is_self_hidden(target_of(scene, body), feature, cam_from_target);
  truth.edges = edge_truths(scene.camera, cam_from_target, feature);
  return truth;
}

// True when one body alone looks as it does here: nothing is in its way, no border cuts it.
bool is_free(const std::vector<PlacedBody>& bodies, const PixelBox& seen, const Camera& camera) {
  return bodies.size() == 1 && seen.left > 0 && seen.top > 0 && seen.right < camera.width_px &&
         seen.bottom < camera.height_px;
}

}  // namespace

std::vector<PlacedBody> placed_bodies(const Scene& scene, const Pose& cam_from_target) {
  std::vector<PlacedBody> bodies;
  bodies.push_back({.mesh = &scene.target->mesh,
                    .cam_from_body = cam_from_target,
                    .stripe_contrast = scene.livery.contrast,
                    .stripe_m = scene.livery.stripe_m});
  for (const OtherBody& other : scene.others) {
    const PlacedBody& before = bodies.back();
    const auto next_id = static_cast<uint32_t>(before.first_id + before.mesh->triangles.size());
    bodies.push_back(
        {.mesh = &other.target->mesh, .cam_from_body = other.cam_from_target, .first_id = next_id});
  }
  return bodies;
}

size_t body_of(const std::vector<PlacedBody>& bodies, uint32_t id) {
  const auto after = std::upper_bound(
      bodies.begin(), bodies.end(), id,
      [](uint32_t value, const PlacedBody& body) { return value < body.first_id; });
  return static_cast<size_t>(after - bodies.begin()) - 1;
}

void state_truth(const Scene& scene, TextureCache& textures, Frame& frame) {
  const std::vector<PlacedBody> bodies = placed_bodies(scene, scene.cam_from_target);
  const cv::Size size(scene.camera.width_px, scene.camera.height_px);
  frame.depth_m = cv::Mat::zeros(size, CV_64F);
  frame.part_ids = cv::Mat::zeros(size, CV_16U);
  frame.body_ids = cv::Mat::zeros(size, CV_8U);
  frame.truth.camera = scene.camera;
  frame.truth.bodies.resize(bodies.size());
  const double reference_m = reference_depth_m(scene.target->mesh, scene.cam_from_target);
  const Screen screen(scene.camera, image_box(scene.camera), reference_m);
  SurfaceOpacity opacity(bodies, scene.colouring.draws_textures, textures);
  const bool looks_through = scene.colouring.truth_sees == TruthSurface::kOpaque;
  const IdImage image = paint_ids(bodies, screen, looks_through ? &opacity : nullptr);
  state_pixels(bodies, image, screen, frame);
  const bool is_alone = is_free(bodies, image.box, scene.camera);
  const Screen canvas(scene.camera, amodal_canvas(scene.camera), reference_m);
  for (size_t b = 0; b < bodies.size(); ++b) {
    BodyTruth& truth = frame.truth.bodies[b];
    truth.cam_from_target = bodies[b].cam_from_body;
    truth.is_occluder = b > 0 && scene.others[b - 1].is_occluder;
    for (const TargetFeature& feature : target_of(scene, b).features) {
      truth.features.push_back(feature_truth(scene, bodies, b, feature));
    }
    if (is_alone) {
      truth.amodal_mask = frame.body_ids != 0;
      truth.amodal_box = truth.visible_box;
      truth.amodal_pixels = truth.visible_pixels;
    } else {
      truth.amodal_mask = cv::Mat::zeros(size, CV_8U);
      state_amodal(bodies[b], canvas, scene, textures, truth);
    }
  }
}

SurfaceMaps surface_maps(const Scene& scene) {
  const std::vector<PlacedBody> bodies = placed_bodies(scene, scene.cam_from_target);
  std::vector<RayHits> hits;
  for (const PlacedBody& body : bodies) hits.emplace_back(body);
  const Screen screen(scene.camera, image_box(scene.camera),
                      reference_depth_m(scene.target->mesh, scene.cam_from_target));
  TextureCache textures;
  SurfaceOpacity opacity(bodies, scene.colouring.draws_textures, textures);
  const bool looks_through = scene.colouring.truth_sees == TruthSurface::kOpaque;
  const cv::Size size(scene.camera.width_px, scene.camera.height_px);
  SurfaceMaps maps{cv::Mat::zeros(size, CV_64FC3), cv::Mat::zeros(size, CV_64FC3)};
  for_each_seen(paint_ids(bodies, screen, looks_through ? &opacity : nullptr), [&](int x, int y,
                                                                                   uint32_t id) {
    const size_t b = body_of(bodies, id);
    const Eigen::Vector2d pixel(x, y);
    const SurfacePoint point =
        hits[b].on(static_cast<int>(id - bodies[b].first_id), screen.normalised(pixel));
    const Eigen::Vector3d normal =
        bodies[b].cam_from_body.rotation * lit_normal(*bodies[b].mesh, point).stableNormalized();
    const Eigen::Vector3d position = hits[b].in_body(point);
    maps.normals.at<cv::Vec3d>(y, x) = {normal.x(), normal.y(), normal.z()};
    maps.positions_m.at<cv::Vec3d>(y, x) = {position.x(), position.y(), position.z()};
  });
  return maps;
}

cv::Mat part_ids_alone(const Scene& scene) {
  const PlacedBody body = placed_bodies(scene, scene.cam_from_target).front();
  const Screen screen(scene.camera, image_box(scene.camera),
                      reference_depth_m(scene.target->mesh, scene.cam_from_target));
  cv::Mat part_ids = cv::Mat::zeros(scene.camera.height_px, scene.camera.width_px, CV_16U);
  for_each_seen(paint_ids({body}, screen), [&](int x, int y, uint32_t id) {
    part_ids.at<uint16_t>(y, x) =
        static_cast<uint16_t>(body.mesh->triangles[id - body.first_id].part + 1);
  });
  return part_ids;
}

cv::Mat depth_alone(const Mesh& mesh, const Camera& camera, const Pose& cam_from_mesh) {
  cv::Mat depth = cv::Mat::zeros(camera.height_px, camera.width_px, CV_64F);
  double nearest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    nearest = std::min(nearest, (cam_from_mesh * vertex).z());
  }
  if (mesh.triangles.empty()) return depth;
  const PlacedBody body{.mesh = &mesh, .cam_from_body = cam_from_mesh};
  const RayHits hits(body);
  const double reference_m = nearest > 0 ? nearest : reference_depth_m(mesh, cam_from_mesh);
  const Screen screen(camera, image_box(camera), reference_m);
  for_each_seen(paint_ids({body}, screen), [&](int x, int y, uint32_t id) {
    const Eigen::Vector2d ray = screen.normalised({static_cast<double>(x), static_cast<double>(y)});
    depth.at<double>(y, x) = hits.depth_m(hits.on(static_cast<int>(id - body.first_id), ray));
  });
  return depth;
}

}  // namespace sightline
