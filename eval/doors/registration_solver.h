// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "eval/doors/registration_setup.h"
#include "eval/doors/trial_solver.h"
#include "features/prediction.h"
#include "registration/model_image.h"
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

/// The mesh as the registration knows it, drawn at a pose beside the image; none where no
/// registration is asked for, or it cannot be drawn.
std::optional<ModelImage> model_beside(const QuestionImage& shown, const Camera& camera,
                                       const Pose& cam_from_target);

/// The registrations that are asked for, as solvers of a trial: registration_image and
/// registration_outline.
std::vector<TrialSolver> registration_solvers(RegistrationUse use);

}  // namespace sightline
