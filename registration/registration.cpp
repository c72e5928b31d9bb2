// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/registration.h"

#include <array>
#include <cmath>

#include "registration/fit.h"

namespace sightline {

std::string_view to_string(RegistrationStatus status) {
  constexpr std::array<std::string_view, 6> kNames = {
      "ok", "behind_camera", "target outside", "target too small", "saturated", "not trusted"};
  return kNames[static_cast<size_t>(status)];
}

Registration register_mesh(const RegistrationTask& task, const RegistrationOptions& options) {
  const GreyImage image = grey_image(task.image, task.white, options.is_srgb, task.camera);
  const double noise_sd = options.noise_sd_grey.value_or(estimated_noise_sd(image.grey));
  const double step_grey = 255 / (std::exp2(options.bits) - 1);
  Fitter fitter(task.mesh, task.prior, noise_sd * noise_sd + step_grey * step_grey / 12, options);
  const std::vector<FitLevel> levels = fit_levels(image, task.start.has_value());
  return fitter.fit(levels, task.start.value_or(task.prior.cam_from_target));
}

}  // namespace sightline
