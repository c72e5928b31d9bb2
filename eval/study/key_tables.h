// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The tables of a study's keys, one line a key: what reads the file and what `sightline list keys`
// prints. Those of the scene are in scenes/scene/. A table points into the structs that it is made
// for, and must not outlive them; what stands in them before the file is read is the default.
#pragma once

#include <vector>

#include "eval/study/study.h"
#include "scenes/scene/keys.h"

namespace sightline {

/// Greatest depth of a data set's grey levels, and what is taken for it where none is given.
inline constexpr int kMostBits = 16;

/// What is left of the mesh's triangles for the removal of bias: a model of the target that
/// somebody made for another purpose.
inline constexpr double kBiasMeshFraction = 0.5;

/// [extraction] with [extraction.lines] and [extraction.corners]. `bias_mesh_fraction` is what is
/// left of the mesh's triangles for the removal of bias.
std::vector<Key> extraction_keys(ImageSetup& setup, double& bias_mesh_fraction);

/// extraction.registration, which says which solvers a study has.
Key registration_key(RegistrationUse& use);

/// [bound].
std::vector<Key> bound_keys(bool& has_image_bound);

/// The extractors of a study that names none.
ExtractorChoice default_extractors();

/// [solver], but for `inputs` and a numeric study's `sigma`.
std::vector<Key> solver_keys(Start& start, SolverOptions& options);

/// `sigma` of [solver].
std::vector<Key> sigma_keys(bool& is_sigma_known);

/// [noise] of a numeric study, but for its standard deviation and scale.
std::vector<Key> noise_keys(NoiseLaw& noise);

/// `scale` of [solver].
std::vector<Key> scale_keys(bool& estimates_scale);

/// [dataset]; `bits` is the depth of its images.
std::vector<Key> dataset_keys(SightingSource& source, int& bits);

/// What an orientation study draws: [points] but for their number, `copies` and `timed_repeats`.
std::vector<Key> point_keys(PointPairs& pairs);

/// [limits].
std::vector<Key> limit_keys(ClaimLimits& limits);

/// Quantities of numeric and orientation studies that [sweep] may have instead.
std::vector<Key> axis_keys();

/// All keys of a study in words, table by table, but for those of the scene.
std::vector<KeyText> study_keys();

}  // namespace sightline
