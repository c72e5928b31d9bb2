// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The parts of the extension module _sightline. It is for the package beside it (python/sightline),
// which checks what users give, has the docstrings, and turns tuples into objects with names.
#pragma once

#include <pybind11/pybind11.h>

#include "pose/solver.h"

namespace sightline {

void bind_pose(pybind11::module_& module);
void bind_study(pybind11::module_& module);
void bind_frames(pybind11::module_& module);

/// An estimate's status, pose, removed, own covariance, unit covariance, diagnosis, iterations,
/// ignored, rms of the residuals, second pose, noise and probabilities of the points; None for what
/// it does not have.
pybind11::tuple tuple_of(const PoseEstimate& estimate);

}  // namespace sightline
