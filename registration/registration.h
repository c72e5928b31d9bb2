// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <opencv2/core/mat.hpp>

#include "features/prediction.h"
#include "registration/model_view.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// Whether a registration has a pose, or why it has none.
enum class RegistrationStatus {
  kOk,
  kBehindCamera,  ///< at the prior the mesh is not wholly in front of the camera
  kOutside,       ///< too little of the target is in the image
  kTooSmall,      ///< too little of an outline is there
  kSaturated,     ///< where the target should be the sensor is at white
  kNotTrusted,    ///< a pose was found, but the image does not look like the model there
};

/// The name that files give to a status.
std::string_view to_string(RegistrationStatus status);

/// Standard deviations of a camera's calibration, independent of each other.
struct CameraErrors {
  double focal_fraction = 0;      ///< of fx and fy, which err together
  double principal_point_px = 0;  ///< of cx and of cy
  double k1 = 0;                  ///< of the lens' first coefficient

  bool is_none() const { return focal_fraction == 0 && principal_point_px == 0 && k1 == 0; }
};

struct RegistrationOptions {
  RegistrationRegion region = RegistrationRegion::kImage;
  /// Standard deviation of the image's noise, grey levels of 255; none: it is estimated.
  std::optional<double> noise_sd_grey;
  int bits = 8;  ///< of the image, for what rounding adds to the noise
  bool is_srgb = false;
  double blur_px = 1;            ///< the point spread to begin with; it is estimated
  CameraErrors camera_errors{};  ///< carried into the covariance
};

/// What a registration is given.
struct RegistrationTask {
  const Mesh& mesh;
  const Camera& camera;
  const cv::Mat& image;  ///< CV_8U or CV_16U
  double white;          ///< its greatest possible value
  PosePrior prior;
  /// A better pose to start from, near enough for the image to be sharp; none: from the prior.
  std::optional<Pose> start;
};

/// A pose of the mesh at which it looks like the image, and how it fits.
struct Registration {
  RegistrationStatus status = RegistrationStatus::kOutside;
  std::string reason;    ///< in words and numbers; empty with kOk
  Pose cam_from_target;  ///< meaningful with kOk, and to be looked at with kNotTrusted
  Matrix6d covariance = Matrix6d::Zero();  ///< of (w, dt), prior included; radians and metres
  LightVector light = LightVector::Zero();
  double blur_px = 0;
  double noise_sd_grey = 0;
  double chi2 = 0;            ///< mean square of the residuals over their variance
  double lost = 0;            ///< share of the pixels that the model does not explain
  double cluster_factor = 0;  ///< of the covariance: what neighbouring blocks err together
  double cost = 0;            ///< -2 log posterior, to compare poses of one image
  double inside_sd = 0, outside_sd = 0;  ///< of the blocks' own light and background
  int drawings = 0;                      ///< of the mesh
  int starts = 0;

  bool is_ok() const { return status == RegistrationStatus::kOk; }
};

/// Lays the mesh on the image: Gauss-Newton on grey levels from blurred images to the sharp one.
/// Light, background and blur are fitted, and every square of 12 px may deviate from the model by a
/// light and a background of its own, whose size the image tells (docs/registration.md).
Registration register_mesh(const RegistrationTask& task, const RegistrationOptions& options);

}  // namespace sightline
