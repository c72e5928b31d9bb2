// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>

#include "scenes/mesh/mesh.h"

namespace sightline {

/// Which registrations of the mesh stand beside a study's solvers.
enum class RegistrationUse { kOff, kImage, kOutline, kBoth };

/// Where a registration starts.
enum class RegistrationStart {
  kAtFeatures,  ///< at the pose of the features found, where it fits the prior; else at the prior
  kAtPrior,
};

/// How the target is laid on images.
struct RegistrationSetup {
  RegistrationUse use = RegistrationUse::kOff;
  RegistrationStart start = RegistrationStart::kAtFeatures;
  double mesh_fraction = 1;   ///< of the triangles, what the model keeps
  bool knows_albedos = true;  ///< of the target's parts; else all are taken for alike
  /// Of the camera's calibration, which its file takes for exact: carried into the covariance.
  double focal_sd_fraction = 0;
  double principal_point_sd_px = 0;
  double distortion_sd = 0;             ///< of k1
  std::optional<double> noise_sd_grey;  ///< none: estimated from the image
  std::shared_ptr<const Mesh> mesh;     ///< the model; null where `use` is kOff
};

}  // namespace sightline
