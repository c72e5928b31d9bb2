// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/basis.h"

#include <algorithm>
#include <array>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <opencv2/core.hpp>

#include "renderer/placed_body.h"
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
      : body_(body),
        camera_(camera),
        screen_(screen),
        pattern_(pattern),
        is_straight_(is_straight(camera)),
        to_light_(to_light_in_cam.value_or(Eigen::Vector3d::Zero())),
        is_lit_all_(!to_light_in_cam) {}

  // The pixel (x, y) of the image into the place `at` (column, row) of the images.
  void add(int x, int y, const uint32_t* ids, const cv::Point& at, BasisImages& images) {
    count(ids);
    if (known_ == 0) return;
    Eigen::Vector2d centre = screen_.normalised({static_cast<double>(x), static_cast<double>(y)});
    Eigen::Matrix2d per_pixel = Eigen::Vector2d(1 / camera_.fx_px, 1 / camera_.fy_px).asDiagonal();
    if (!is_straight_) per_pixel *= lens_jacobian(camera_, centre).inverse();
    int covered = 0;
    double albedo = 0;
    Eigen::Vector3d albedo_normal = Eigen::Vector3d::Zero();
    Eigen::Vector3d front(0, 0, std::numeric_limits<double>::max());
    for (int i = 0; i < known_; ++i) {
      const Seen& seen = seen_[static_cast<size_t>(i)];
      const Facet& facet = facet_of(seen.id - 1);
      const Eigen::Vector2d offset(pattern_.x[seen.sample], pattern_.y[seen.sample]);
      const SurfacePoint hit =
          surface_point(facet.triangle, facet.across * (centre + per_pixel * offset).homogeneous());
      const double part = seen.samples * facet.albedo;
      covered += seen.samples;
      albedo += part;
      albedo_normal += part * lit_normal(facet, hit);
      const Eigen::Vector3d point = facet.corners * hit.weights;
      if (point.z() < front.z()) front = point;
    }
    const double share = 1.0 / pattern_.count;
    images.coverage.at<float>(at) = static_cast<float>(covered * share);
    images.albedo.at<float>(at) = static_cast<float>(albedo * share);
    for (size_t k = 0; k < 3; ++k) {
      images.albedo_normal[k].at<float>(at) =
          static_cast<float>(albedo_normal[static_cast<int>(k)] * share);
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

  // What the pixels that see a triangle need of it, in the camera.
  struct Facet {
    uint32_t triangle = std::numeric_limits<uint32_t>::max();
    double albedo = 0;
    bool is_flat = false;     // its corners' normals are the same
    Eigen::Matrix3d corners;  // by columns, as the normals
    Eigen::Matrix3d normals;
    Eigen::Matrix3d across;  // by a ray: the volumes that it spans with the edges
  };

  // Where a ray meets a triangle: weights of its corners, and from which side.
  void count(const uint32_t* ids) {
    const uint32_t first = ids[0];
    uint32_t differs = 0;
    for (int k = 1; k < pattern_.count; ++k) differs |= ids[k] ^ first;
    if (differs == 0) {
      known_ = first == 0 ? 0 : 1;
      seen_[0] = {first, 0, pattern_.count};
      return;
    }
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

  // Neighbouring pixels see the same few triangles: those are kept.
  const Facet& facet_of(uint32_t triangle) {
    Facet& facet = facets_[triangle % facets_.size()];
    if (facet.triangle != triangle) facet = made_facet(triangle);
    return facet;
  }

  Facet made_facet(uint32_t triangle) const {
    const Mesh& mesh = *body_.mesh;
    const Triangle& of_mesh = mesh.triangles[triangle];
    Facet facet;
    facet.triangle = triangle;
    facet.albedo = mesh.parts[static_cast<size_t>(of_mesh.part)].albedo;
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<size_t>(i);
      facet.corners.col(i) =
          body_.cam_from_body * mesh.vertices[static_cast<size_t>(of_mesh.vertex[k])];
      facet.normals.col(i) = body_.cam_from_body.rotation * of_mesh.normal[k];
    }
    facet.is_flat =
        of_mesh.normal[0] == of_mesh.normal[1] && of_mesh.normal[0] == of_mesh.normal[2];
    // A triangle without area has none.
    if (facet.is_flat && !facet.normals.isZero(0)) facet.normals.colwise().normalize();
    for (int i = 0; i < 3; ++i) {
      facet.across.row(i) = facet.corners.col((i + 1) % 3).cross(facet.corners.col((i + 2) % 3));
    }
    return facet;
  }

  // The unit shading normal in the camera; zero where it is turned away from the light. The inside
  // of an open mesh is lit as a sheet of paper is, as the renderer does.
  Eigen::Vector3d lit_normal(const Facet& facet, const SurfacePoint& hit) const {
    Eigen::Vector3d normal = facet.normals.col(0);
    if (!facet.is_flat) normal = facet.normals * hit.weights;
    if (!hit.is_front) normal = -normal;
    const double length = facet.is_flat ? 1 : normal.norm();
    if (!(length > 0)) return Eigen::Vector3d::Zero();
    if (!is_lit_all_ && normal.dot(to_light_) <= 0) return Eigen::Vector3d::Zero();
    return normal / length;
  }

  PlacedBody body_;
  const Camera& camera_;
  const Screen& screen_;
  const SamplePattern& pattern_;
  bool is_straight_;
  Eigen::Vector3d to_light_;  // in the camera
  bool is_lit_all_;
  std::vector<Seen> seen_ = std::vector<Seen>(static_cast<size_t>(pattern_.count));
  int known_ = 0;  // entries of seen_
  std::array<Facet, 64> facets_;
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
