// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "registration/adaptive_solve.h"
#include "registration/registration.h"

namespace sightline {

/// An image at one step from blurred to sharp.
struct FitLevel {
  GreyImage image;
  int factor = 1;      ///< how much smaller than the whole
  double blur_px = 0;  ///< of the image, besides its own; 0: the sharp image
  int most_steps = 6;
  int samples = 16;  ///< of a pixel of the model

  bool is_sharp() const { return blur_px == 0; }
};

/// The variance of a pixel's noise, rounding included: as stated, or else estimated.
double noise_variance(const GreyImage& image, const RegistrationOptions& options);

/// The image from most blurred to sharp; the sharp one alone where `is_near`.
std::vector<FitLevel> fit_levels(const GreyImage& image, bool is_near);

/// What is fitted.
struct FitState {
  Pose cam_from_target;
  std::optional<LightVector> light;  ///< none: not yet known
  double blur_variance_px2 = 1;      ///< the sensor's, in pixels of the whole image
};

/// Fits a mesh to one image from one start.
class Fitter {
 public:
  /// All must outlive it. `noise_variance` is that of a pixel, rounding included.
  Fitter(const Mesh& mesh, const PosePrior& prior, double noise_variance,
         const RegistrationOptions& options);

  /// From level to level. `blurred_sd` is what squares of blurred images may deviate by, grey
  /// levels: little leads farther, much stands printed faces. With status kOk, or without a pose.
  Registration fit(const std::vector<FitLevel>& levels, const Pose& start, double blurred_sd);

 private:
  bool linearise(const FitLevel& level, int samples, BasisDrawer& drawer);
  int sharp_samples(const FitLevel& level, int step) const;
  bool fit_blurred(const FitLevel& level, double deviation_sd);
  bool fit_sharp(const FitLevel& level, Registration& out);
  Solution solve_sharp();
  PriorTerm prior_term(bool is_sharp) const;
  double apply(const Unknowns& change, bool is_sharp);
  Matrix6d camera_term(const FitLevel& level);
  void fit_first_light(const GreyImage& image, const ModelView& view);

  const Mesh& mesh_;
  const PosePrior& prior_;
  Matrix6d prior_information_;
  double noise_variance_;
  const RegistrationOptions& options_;
  double radius_m_;
  FitState state_;
  BlockRows rows_;     // of the last linearisation
  Learning learning_;  // of the sharp image
  int drawings_ = 0;
};

}  // namespace sightline
