// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/facet_view.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "features/normal_law.h"

namespace sightline {
namespace {

using namespace facet_parameter;

constexpr double kBandPx = 3;  // of a pixel from the nearest edge
// Borders through the very middle of a pixel would leave it open what is inside.
const Eigen::Vector2d kAsidePx(1.3e-7, 0.7e-7);
constexpr double kBlurReach = 4.5;  // blurs from an edge within which it is felt

// A point of the target in the image, near the one that moves and about which it turns.
struct ImagePoint {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, kMotion> by_motion;
};

class LocalCamera {
 public:
  LocalCamera(const Camera& camera, const Pose& cam_from_target, const Eigen::Vector3d& centre)
      : cam_from_target_(cam_from_target),
        centre_(centre),
        focal_px_(camera.fx_px, camera.fy_px),
        pixel_(*project(camera, centre)),
        lens_(lens_jacobian(camera, centre.head<2>() / centre.z())) {}

  const Eigen::Vector2d& pixel() const { return pixel_; }
  const Eigen::Matrix2d& lens() const { return lens_; }

  // None for a point much nearer than the centre, or behind the camera.
  std::optional<ImagePoint> at(const Eigen::Vector3d& point_m) const {
    constexpr double kNearest = 0.1;
    const Eigen::Vector3d x = cam_from_target_ * point_m;
    if (!(x.z() > kNearest * centre_.z())) return std::nullopt;
    const Eigen::Vector3d arm = x - centre_;
    Eigen::Matrix<double, 2, 3> by_point;
    by_point << focal_px_.x() / x.z(), 0, -focal_px_.x() * x.x() / (x.z() * x.z()), 0,
        focal_px_.y() / x.z(), -focal_px_.y() * x.y() / (x.z() * x.z());
    Eigen::Matrix3d by_turn;  // of w x arm
    by_turn << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
    ImagePoint out;
    out.pixel = pixel_ + lens_ * focal_px_.cwiseProduct(x.head<2>() / x.z() -
                                                        centre_.head<2>() / centre_.z());
    out.by_motion << lens_ * (centre_.z() / x.z()), lens_ * by_point * by_turn;
    return out;
  }

 private:
  const Pose& cam_from_target_;
  Eigen::Vector3d centre_;
  Eigen::Vector2d focal_px_;
  Eigen::Vector2d pixel_;
  Eigen::Matrix2d lens_;
};

BorderStretch stretch_between(const ImagePoint& begin, const ImagePoint& end) {
  BorderStretch stretch;
  const Eigen::Vector2d along = end.pixel - begin.pixel;
  stretch.begin = begin.pixel;
  stretch.length_px = along.norm();
  stretch.direction =
      stretch.length_px > 0 ? Eigen::Vector2d(along / stretch.length_px) : Eigen::Vector2d::UnitX();
  stretch.down_px = along.y();
  stretch.normal = {-stretch.direction.y(), stretch.direction.x()};
  stretch.begin_by_motion = begin.by_motion.transpose() * stretch.normal;
  stretch.end_by_motion = end.by_motion.transpose() * stretch.normal;
  return stretch;
}

double distance_px(const BorderStretch& stretch, const Eigen::Vector2d& pixel) {
  const double nearest =
      std::clamp((pixel - stretch.begin).dot(stretch.direction), 0.0, stretch.length_px);
  return (stretch.begin + nearest * stretch.direction - pixel).norm();
}

// True where no ray that leaves a pixel of the box along its row meets the stretch: then it does
// not say whether the pixel is inside a facet.
bool is_never_met(const BorderStretch& stretch, const Eigen::AlignedBox2d& box) {
  const Eigen::Vector2d end = stretch.begin + stretch.length_px * stretch.direction;
  return std::max(stretch.begin.y(), end.y()) < box.min().y() ||
         std::min(stretch.begin.y(), end.y()) > box.max().y() ||
         std::max(stretch.begin.x(), end.x()) < box.min().x();
}

// What of the row the blur across one stretch adds.
void add_blur(const BorderStretch& stretch, double d_px, double along_px, const FacetVector& x,
              FacetRow& row) {
  const NormalLaw& law = normal_law();
  const double s = x[kBlur];
  const double per_blur = 1 / s;
  const double h = d_px * per_blur;
  const double to_begin = along_px * per_blur;
  const double to_end = (stretch.length_px - along_px) * per_blur;
  const NormalLaw::Value across = law.at(-std::abs(h));
  double carried = across.cumulative;
  double mass = 1;  // of the Gaussian along the stretch, and its part that moves with the end
  double end_part = along_px / stretch.length_px;
  if (to_begin < kBlurReach || to_end < kBlurReach) {
    carried = owens_t(std::abs(h), to_begin) + owens_t(std::abs(h), to_end);
    const NormalLaw::Value begin = law.at(-to_begin);
    const NormalLaw::Value end = law.at(to_end);
    mass = end.cumulative - begin.cumulative;
    const double moment_px = along_px * mass - s * (end.density - begin.density);
    end_part = stretch.length_px > 0 ? moment_px / stretch.length_px : 0;
  }
  if (d_px < 0) carried = -carried;
  row[kGreys + stretch.left] += carried;
  row[kGreys + stretch.right] -= carried;
  const double by_move =
      across.density * per_blur * (x[kGreys + stretch.left] - x[kGreys + stretch.right]);
  const double by_begin = by_move * (mass - end_part);
  const double by_end = by_move * end_part;
  for (int i = 0; i < kMotion; ++i) {
    row[i] += by_begin * stretch.begin_by_motion[i] + by_end * stretch.end_by_motion[i];
  }
  row[kBlur] += by_move * h * mass;
}

// Marks row by row the pixels within kBandPx of the stretch.
void mark_band(const BorderStretch& stretch, const cv::Rect& box, cv::Mat& marks) {
  const Eigen::Vector2d end = stretch.begin + stretch.length_px * stretch.direction;
  const double top = std::min(stretch.begin.y(), end.y()) - kBandPx;
  const double bottom = std::max(stretch.begin.y(), end.y()) + kBandPx;
  const int first_v = static_cast<int>(std::ceil(std::max<double>(box.y, top)));
  const int last_v = static_cast<int>(std::floor(std::min<double>(box.br().y - 1, bottom)));
  for (int v = first_v; v <= last_v; ++v) {
    double lo = box.x;
    double hi = box.br().x - 1;
    // normal . (p - begin) between two limits.
    const auto cut = [&](const Eigen::Vector2d& normal, double least, double most) {
      const double rest = normal.y() * (v - stretch.begin.y());
      if (normal.x() == 0) {
        if (rest < least || rest > most) hi = lo - 1;
        return;
      }
      const double a = stretch.begin.x() + (least - rest) / normal.x();
      const double b = stretch.begin.x() + (most - rest) / normal.x();
      lo = std::max(lo, std::min(a, b));
      hi = std::min(hi, std::max(a, b));
    };
    cut(stretch.normal, -kBandPx, kBandPx);
    cut(stretch.direction, -kBandPx, stretch.length_px + kBandPx);
    uint8_t* const row = marks.ptr<uint8_t>(v - box.y);
    for (int u = static_cast<int>(std::ceil(lo)); u <= hi; ++u) row[u - box.x] = 1;
  }
}

}  // namespace

std::optional<FacetView> FacetView::of(const FacetPatch& patch, const Pose& cam_from_target) {
  const Eigen::Vector3d centre = cam_from_target * patch.point_m;
  if (!(centre.z() > 0)) return std::nullopt;
  const LocalCamera camera(patch.camera, cam_from_target, centre);
  const std::vector<Facet>& facets = patch.facets.facets;
  const Eigen::Vector3d eye_m = inverse(cam_from_target).translation;
  const double reach_px = patch.reach_px + kBlurReach * FacetView::kMostBlurPx;

  FacetView view;
  view.pixel_ = camera.pixel();
  view.lens_ = camera.lens();
  std::vector<Eigen::AlignedBox2d> box(facets.size());
  std::vector<std::array<int, 2>> sides;
  for (const FacetEdge& edge : patch.facets.edges) {
    const bool is_seen =
        facets[edge.facet[0]].is_towards(eye_m) || facets[edge.facet[1]].is_towards(eye_m);
    if (!is_seen) continue;
    const auto begin = camera.at(edge.begin_m);
    const auto end = camera.at(edge.end_m);
    if (!begin || !end) return std::nullopt;
    BorderStretch stretch = stretch_between(*begin, *end);
    stretch.is_near = distance_px(stretch, view.pixel_) < reach_px;
    for (const int facet : edge.facet) box[facet].extend(begin->pixel).extend(end->pixel);
    view.stretches_.push_back(stretch);
    sides.push_back(edge.facet);
  }
  const Eigen::AlignedBox2d around(Eigen::Vector2d(view.pixel_.array() - reach_px),
                                   Eigen::Vector2d(view.pixel_.array() + reach_px));
  std::vector<int> grey_of(facets.size(), 0);
  for (size_t f = 0; f < facets.size(); ++f) {
    if (!facets[f].is_towards(eye_m) || !box[f].intersects(around)) continue;
    if (!facets[f].is_even || view.seen_.size() == kMostSeen) return std::nullopt;
    view.seen_.push_back(static_cast<int>(f));
    grey_of[f] = static_cast<int>(view.seen_.size());
  }
  if (view.seen_.empty()) return std::nullopt;
  for (size_t i = 0; i < sides.size(); ++i) {
    view.stretches_[i].left = grey_of[sides[i][0]];
    view.stretches_[i].right = grey_of[sides[i][1]];
  }
  std::erase_if(view.stretches_, [&](const BorderStretch& stretch) {
    return stretch.left == stretch.right || (!stretch.is_near && is_never_met(stretch, around));
  });
  return view;
}

// The greys' shares are the winding numbers of the facets' borders about the pixel, and what the
// blur carries across them.
void FacetView::fill_row(double u, double v, const FacetVector& x, FacetRow& row) const {
  const double reach_px = kBlurReach * x[kBlur];
  row.fill(0);
  row[kGreys] = 1;
  for (const BorderStretch& stretch : stretches_) {
    const double off_u = u + kAsidePx.x() - stretch.begin.x();
    const double off_v = v + kAsidePx.y() - stretch.begin.y();
    const double d_px = off_u * stretch.normal.x() + off_v * stretch.normal.y();
    if ((off_v >= 0) != (off_v >= stretch.down_px)) {
      const double turns = stretch.down_px < 0 ? (d_px < 0 ? 1 : 0) : (d_px > 0 ? -1 : 0);
      row[kGreys + stretch.left] += turns;
      row[kGreys + stretch.right] -= turns;
    }
    if (!stretch.is_near || std::abs(d_px) > reach_px) continue;
    const double along_px = off_u * stretch.direction.x() + off_v * stretch.direction.y();
    if (along_px < -reach_px || along_px > stretch.length_px + reach_px) continue;
    add_blur(stretch, d_px, along_px, x, row);
  }
}

std::vector<PatchPixel> FacetView::pixels(const FacetPatch& patch) const {
  constexpr double kOverlap = 1e-3;
  const int reach = static_cast<int>(patch.reach_px);
  const cv::Point centre(static_cast<int>(std::lround(pixel_.x())),
                         static_cast<int>(std::lround(pixel_.y())));
  const cv::Rect box = cv::Rect(centre.x - reach, centre.y - reach, 2 * reach + 1, 2 * reach + 1) &
                       cv::Rect({0, 0}, patch.image.size());
  if (box.empty()) return {};
  cv::Mat marks = cv::Mat::zeros(box.size(), CV_8U);
  for (const BorderStretch& stretch : stretches_) {
    if (stretch.is_near) mark_band(stretch, box, marks);
  }
  FacetVector wide = FacetVector::Zero(kGreys + greys());
  wide[kBlur] = 2 * kUsualBlurPx;
  FacetRow row;
  std::vector<PatchPixel> pixels;
  for (int v = box.y; v < box.br().y; ++v) {
    const uint8_t* const marked = marks.ptr<uint8_t>(v - box.y);
    const uint8_t* const greys = patch.image.ptr<uint8_t>(v);
    for (int u = box.x; u < box.br().x; ++u) {
      if (marked[u - box.x] == 0) continue;
      const Eigen::Vector2d p(u, v);
      if ((p - pixel_).squaredNorm() > patch.reach_px * patch.reach_px) continue;
      if (!patch.facets.is_convex) {
        fill_row(u, v, wide, row);
        if (row[kGreys] < -kOverlap) continue;
      }
      pixels.push_back({p.x(), p.y(), static_cast<double>(greys[u])});
    }
  }
  return pixels;
}

}  // namespace sightline
