// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/model_image.h"

#include <cmath>
#include <limits>

#include <opencv2/core.hpp>

#include "registration/fit.h"
#include "registration/model_view.h"

namespace sightline {

std::optional<ModelImage> model_image(const RegistrationTask& task,
                                      const RegistrationOptions& options,
                                      const Pose& cam_from_target) {
  constexpr double kUsualDeviationSd = 3;  // of blurred images, which are not asked here
  const GreyImage image = grey_image(task.image, task.white, options.is_srgb, task.camera);
  const double variance = noise_variance(image, options);
  RegistrationOptions of_image = options;
  of_image.region = RegistrationRegion::kImage;
  of_image.camera_errors = {};
  // A pose that is known exactly stays where it is while light and blur are fitted.
  PosePrior held = task.prior;
  held.cam_from_target = cam_from_target;
  held.covariance.setZero();
  Fitter fitter(task.mesh, held, variance, of_image);
  const Registration fit = fitter.fit(fit_levels(image, true), cam_from_target, kUsualDeviationSd);
  if (!fit.is_ok()) return std::nullopt;
  BasisDrawer drawer(task.mesh, task.camera);
  BasisOptions basis;
  basis.margin_px = margin_px(fit.blur_px);
  basis.to_light_in_cam = fit.light.segment<3>(1);
  const auto images = drawer.draw(cam_from_target, basis);
  if (!images) return std::nullopt;
  const ModelView view = model_view(*images, fit.blur_px, RegistrationRegion::kImage);
  ModelImage out{view.box, model_picture(view, fit.light).grey, {}};
  out.residual_sds = (image.grey(view.box) - out.model_grey) / std::sqrt(variance);
  const cv::Mat is_left_out = (view.is_used == 0) | image.is_clipped(view.box);
  out.residual_sds.setTo(std::numeric_limits<float>::quiet_NaN(), is_left_out);
  return out;
}

}  // namespace sightline
