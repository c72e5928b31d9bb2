// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/observation.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace sightline {

std::string_view to_string(ObservationStatus status) {
  switch (status) {
    case ObservationStatus::kFound:
      return "found";
    case ObservationStatus::kHidden:
      return "hidden";
    case ObservationStatus::kOutsideImage:
      return "outside the image";
    case ObservationStatus::kWindowTooSmall:
      return "window too small";
    case ObservationStatus::kSaturated:
      return "saturated window";
    case ObservationStatus::kEmptyWindow:
      return "empty window";
    case ObservationStatus::kNoOutline:
      return "no outline to look for";
    case ObservationStatus::kTooFewEdgePixels:
      return "too few edge pixels";
    case ObservationStatus::kParallelLines:
      return "parallel lines";
    case ObservationStatus::kOutsideWindow:
      return "lines meet outside the window";
    case ObservationStatus::kNoCorner:
      return "no corner";
    case ObservationStatus::kMissing:
      return "missing";
  }
  return "unknown";
}

double worst_sd_px(const Eigen::Matrix2d& covariance_px2) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance_px2);
  return std::sqrt(eigen.eigenvalues()[1]);
}

}  // namespace sightline
