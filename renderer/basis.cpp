// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/basis.h"

#include <algorithm>
#include <limits>

#include <Eigen/LU>
#include <opencv2/core.hpp>

#include "renderer/screen.h"
#include "renderer/shading.h"

namespace sightline {
namespace {

bool is_in_front(const Mesh& mesh, const Pose& cam_from_mesh) {
  return std::all_of(
      mesh.vertices.begin(), mesh.vertices.end(),
      [&](const Eigen::Vector3d& vertex) { return (cam_from_mesh * vertex).z() > 0; });
}

BasisImages empty_images(const cv::Rect& box) {
  BasisImages images;
  images.box = box;
  images.coverage = cv::Mat::zeros(box.size(), CV_32F);
  images.albedo = cv::Mat::zeros(box.size(), CV_32F);
  for (cv::Mat& image : images.albedo_normal) image = cv::Mat::zeros(box.size(), CV_32F);
  images.front_m = cv::Mat::zeros(box.size(), CV_32FC3);
  return images;
}

}  // namespace

// Adds up what the samples of a pixel see, triangle by triangle.
class BasisDrawer::PixelSums {
 public:
  PixelSums(const PlacedBody& body, const Camera& camera, const Screen& screen,
            const SamplePattern& pattern, const std::optional<Eigen::Vector3d>& to_light_in_cam)
      : hits_(body), camera_(camera), screen_(screen), pattern_(pattern) {
    if (to_light_in_cam) to_light_ = body.cam_from_body.rotation.transpose() * *to_light_in_cam;
    is_lit_all_ = !to_light_in_cam;
  }

  // The pixel (x, y) of the image into the place `at` (column, row) of the images.
  void add(int x, int y, const uint32_t* ids, const cv::Point& at, BasisImages& images) {
    Eigen::Vector2d centre = screen_.normalised({static_cast<double>(x), static_cast<double>(y)});
    Eigen::Matrix2d per_pixel = Eigen::Vector2d(1 / camera_.fx_px, 1 / camera_.fy_px).asDiagonal();
    if (!is_straight(camera_)) per_pixel *= lens_jacobian(camera_, centre).inverse();
    count(ids);
    int covered = 0;
    double albedo = 0;
    Eigen::Vector3d albedo_normal = Eigen::Vector3d::Zero();
    Eigen::Vector3d front(0, 0, std::numeric_limits<double>::max());
    for (int i = 0; i < known_; ++i) {
      const Seen& seen = seen_[static_cast<size_t>(i)];
      const Eigen::Vector2d offset(pattern_.x[seen.sample], pattern_.y[seen.sample]);
      const SurfacePoint point =
          hits_.on(static_cast<int>(seen.id - 1), centre + per_pixel * offset);
      const double part = seen.samples * albedo_of(point);
      covered += seen.samples;
      albedo += part;
      albedo_normal += part * lit_normal(point);
      const Eigen::Vector3d x_in_cam = hits_.body().cam_from_body * hits_.in_body(point);
      if (x_in_cam.z() < front.z()) front = x_in_cam;
    }
    if (covered == 0) return;
    const Eigen::Vector3d turned = hits_.body().cam_from_body.rotation * albedo_normal;
    const double share = 1.0 / pattern_.count;
    images.coverage.at<float>(at) = static_cast<float>(covered * share);
    images.albedo.at<float>(at) = static_cast<float>(albedo * share);
    for (size_t k = 0; k < 3; ++k) {
      images.albedo_normal[k].at<float>(at) =
          static_cast<float>(turned[static_cast<int>(k)] * share);
    }
    const Eigen::Vector3f f = front.cast<float>();
    images.front_m.at<cv::Vec3f>(at) = cv::Vec3f(f.x(), f.y(), f.z());
  }

 private:
  // A triangle that samples of the pixel see: how many, and the one nearest to the pixel's centre.
  struct Seen {
    uint32_t id = 0;
    int sample = 0;
    int samples = 0;
  };

  void count(const uint32_t* ids) {
    known_ = 0;
    for (int k = 0; k < pattern_.count; ++k) {
      const uint32_t id = ids[k];
      if (id == 0) continue;
      int i = known_ - 1;
      while (i >= 0 && seen_[static_cast<size_t>(i)].id != id) --i;
      if (i < 0) {
        i = known_++;
        seen_[static_cast<size_t>(i)] = {id, k, 0};
      }
      ++seen_[static_cast<size_t>(i)].samples;
    }
  }

  double albedo_of(const SurfacePoint& point) const {
    const Mesh& mesh = *hits_.body().mesh;
    return mesh.parts[static_cast<size_t>(mesh.triangles[static_cast<size_t>(point.triangle)].part)]
        .albedo;
  }

  // The unit shading normal in the mesh's frame; zero where it is turned away from the light. The
  // inside of an open mesh is lit as a sheet of paper is, as the renderer does.
  Eigen::Vector3d lit_normal(const SurfacePoint& point) const {
    const auto& corners = hits_.body().mesh->triangles[static_cast<size_t>(point.triangle)].normal;
    Eigen::Vector3d normal = point.weights[0] * corners[0] + point.weights[1] * corners[1] +
                             point.weights[2] * corners[2];
    if (!point.is_front) normal = -normal;
    const double length = normal.norm();
    if (!(length > 0)) return Eigen::Vector3d::Zero();
    if (!is_lit_all_ && normal.dot(to_light_) <= 0) return Eigen::Vector3d::Zero();
    return normal / length;
  }

  RayHits hits_;
  const Camera& camera_;
  const Screen& screen_;
  const SamplePattern& pattern_;
  Eigen::Vector3d to_light_ = Eigen::Vector3d::Zero();  // mesh's frame
  bool is_lit_all_ = true;
  std::vector<Seen> seen_ = std::vector<Seen>(static_cast<size_t>(pattern_.count));
  int known_ = 0;  // entries of seen_
};

BasisDrawer::BasisDrawer(const Mesh& mesh, const Camera& camera)
    : mesh_(mesh), camera_(camera), painter_(make_own_painter()) {}

std::optional<BasisImages> BasisDrawer::draw(const Pose& cam_from_mesh,
                                             const BasisOptions& options) {
  if (!is_in_front(mesh_, cam_from_mesh)) return std::nullopt;
  const PixelBox canvas{0, 0, camera_.width_px, camera_.height_px};
  const Screen screen(camera_, canvas, cam_from_mesh.translation.z());
  on_screen_.clear();
  screen.append(mesh_, cam_from_mesh, 1, on_screen_);
  const PixelBox touched = touched_box(on_screen_, canvas);
  if (touched.is_empty()) return std::nullopt;
  const int margin = options.margin_px;
  BasisImages images =
      empty_images(cv::Rect(touched.left - margin, touched.top - margin,
                            touched.width() + 2 * margin, touched.height() + 2 * margin) &
                   cv::Rect(0, 0, camera_.width_px, camera_.height_px));
  PlacedBody body;
  body.mesh = &mesh_;
  body.cam_from_body = cam_from_mesh;
  const SamplePattern& pattern = sample_pattern(options.samples_per_pixel);
  PixelSums sums(body, camera_, screen, pattern, options.to_light_in_cam);
  painter_->start(on_screen_, touched, pattern);
  while (painter_->next(strip_)) {
    for (int y = strip_.box.top; y < strip_.box.bottom; ++y) {
      for (int x = strip_.box.left; x < strip_.box.right; ++x) {
        const size_t pixel = strip_.pixel(x, y);
        if (!strip_.is_touched[pixel]) continue;
        sums.add(x, y, strip_.ids.data() + pixel * static_cast<size_t>(pattern.count),
                 {x - images.box.x, y - images.box.y}, images);
      }
    }
  }
  return images;
}

}  // namespace sightline
