// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The image around a point of a target made of flat facets, explained as a whole: facets of one
// grey each before an even background, blurred. Edges that blur into one another, which no fit of
// one line tells apart, are told apart by it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "features/facet_view.h"
#include "pose/pose.h"

namespace sightline {

struct FacetFit {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< of the point
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();
  Pose cam_from_target;  ///< that explains the patch; elsewhere it may be far off
  double rms_grey = 0;   ///< of the residuals
};

/// The pixel of the patch's point by least squares on the grey levels near the facets' edges, which
/// for white noise is maximum likelihood: over that pixel, a turn of the target about the point,
/// the grey levels and the width of the blur. The pose must be right to a pixel or so around the
/// point. The noise, or the scatter about the fit if that is more, makes the covariance. None where
/// the facets there are rounded or too many, or the point cannot be had of them.
std::optional<FacetFit> fit_facets(const FacetPatch& patch, const Pose& cam_from_target);

/// Of these poses the ones, at most `most`, at which the patch looks most like the image, best
/// first: where a fit is worth beginning.
std::vector<Pose> most_alike(const FacetPatch& patch, std::span<const Pose> poses, size_t most);

}  // namespace sightline
