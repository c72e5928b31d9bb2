// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is expected of an image around a point of a target made of flat facets, pixel by pixel, and
// how that changes as the target moves.
//
// The model: grey(p) = background + sum over facets (grey_f - background) C_f(p), where C_f is the
// share of a Gaussian about p that falls on the facet's image: 1 or 0 as p lies in it or not, and
// at each stretch of its border what the blur carries across, which is Owen's T function. Moving a
// stretch changes C_f by the Gaussian's integral along it times the motion, in closed form. A
// pixel's square adds 1/12 to s^2, so that s stands for blur and pixel at once.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "features/normal_equations.h"
#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/target/facets.h"

namespace sightline {

/// The part of an image that a fit is to explain.
struct FacetPatch {
  const cv::Mat& image;  ///< CV_8U
  const Facets& facets;
  const Camera& camera;
  Eigen::Vector3d point_m;  ///< of the target: a corner of its facets
  double reach_px = 30;     ///< how far around it
  double noise_sd_grey = 3;
};

/// What a patch's image depends on, in the order of a vector of it: the motion (the point's pixel
/// without the lens, then a turn of the target about it, radians in the camera's axes), the blur s,
/// px, and the greys of the background and of the facets seen.
namespace facet_parameter {
inline constexpr int kMotion = 5;
inline constexpr int kTurn = 2;
inline constexpr int kBlur = 5;
inline constexpr int kGreys = 6;
inline constexpr int kMostSeen = 7;
inline constexpr int kMost = kGreys + 1 + kMostSeen;
}  // namespace facet_parameter

using FacetVector = SmallVector;
static_assert(facet_parameter::kMost <= kMostUnknowns);
/// The derivatives of a pixel's grey by all parameters; those by the greys are their shares of it.
using FacetRow = std::array<double, facet_parameter::kMost>;

struct PatchPixel {
  double u, v, grey;
};

/// A stretch of a facet's border in the image.
struct BorderStretch {
  Eigen::Vector2d begin;
  Eigen::Vector2d direction;
  Eigen::Vector2d normal;  ///< from its left facet to its right one
  double length_px;
  double down_px;   ///< of its end from its beginning
  int left, right;  ///< which of the greys lies there
  bool is_near;     ///< the patch
  /// How its ends move along the normal with the motion.
  Eigen::Matrix<double, facet_parameter::kMotion, 1> begin_by_motion, end_by_motion;
};

/// What the facets around a patch's point look like at a pose.
class FacetView {
 public:
  /// Takes the camera for a pinhole whose lens is linear about the point, so that straight stays
  /// straight. None where a facet in the patch is rounded or behind the camera, or there are more
  /// than kMostSeen.
  static std::optional<FacetView> of(const FacetPatch& patch, const Pose& cam_from_target);

  const Eigen::Vector2d& pixel() const { return pixel_; }
  /// The derivative of the pixel by that without the lens.
  const Eigen::Matrix2d& lens() const { return lens_; }
  int greys() const { return 1 + static_cast<int>(seen_.size()); }
  bool sees_same(const FacetView& other) const { return seen_ == other.seen_; }

  /// Those of the patch within a band of an edge, where no facet hides another.
  std::vector<PatchPixel> pixels(const FacetPatch& patch) const;

  /// What is expected of a pixel with these parameters.
  void fill_row(double u, double v, const FacetVector& x, FacetRow& row) const;

  static constexpr double kMostBlurPx = 2.5;  ///< that it is made for
  static constexpr double kUsualBlurPx = 0.9;

 private:
  Eigen::Vector2d pixel_ = Eigen::Vector2d::Zero();
  Eigen::Matrix2d lens_ = Eigen::Matrix2d::Identity();
  std::vector<int> seen_;  // facets
  std::vector<BorderStretch> stretches_;
};

}  // namespace sightline
