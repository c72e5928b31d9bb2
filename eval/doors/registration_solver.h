// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "eval/doors/registration_setup.h"
#include "eval/doors/trial_solver.h"
#include "features/prediction.h"
#include "scenes/scene/scene.h"
#include "scenes/target/target.h"

namespace sightline {

/// The image of a trial and what is known of it, for solvers that look at it themselves.
struct QuestionImage {
  const cv::Mat& image;  ///< CV_8U or CV_16U
  /// Of it solvers look only at how numbers stand for light, but those for evaluation at all.
  const Scene& scene;
  PosePrior prior;
  const RegistrationSetup& registration;
};

/// The target's mesh as a setup knows it.
std::shared_ptr<const Mesh> registration_mesh(const std::shared_ptr<const Target>& target,
                                              const RegistrationSetup& setup);

/// The registrations that are asked for, as solvers of a trial: registration_image and
/// registration_outline.
std::vector<TrialSolver> registration_solvers(RegistrationUse use);

}  // namespace sightline
