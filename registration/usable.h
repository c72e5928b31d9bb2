// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "registration/grey_image.h"
#include "registration/registration.h"

namespace sightline {

/// Whether enough of a target is to be seen for a registration.
struct Usability {
  RegistrationStatus status = RegistrationStatus::kOk;
  std::string reason;
};

/// Looks at where the prior expects the mesh: at least 100 px of its outline must lie in the image,
/// and where the sensor is not at white.
Usability usability(const RegistrationTask& task, const GreyImage& image);

}  // namespace sightline
