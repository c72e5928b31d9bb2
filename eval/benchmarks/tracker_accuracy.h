// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How near to the truth, how repeatable and how fast a mesh is laid on images, beside ViSP.
#pragma once

namespace sightline {

/// `sightline_bench trackers [key=value ...]` prints a table: of rendered frames of two targets,
/// and of the photographs that SIGHTLINE_TEST_REAL names, the errors of the registration and of
/// ViSP's tracker from the same priors. Keys:
///   frames=5    rendered ones of each target
///   priors=20   of each frame, as its study draws them; of photographs 2 degrees, 1 % and 3 px
///   seed=1      of the priors
///   targets=boeing707,cube,photographs
/// The exit code is 1 where a set of photographs cannot be read, 2 for a key or value that it does
/// not know.
int run_tracker_accuracy(int argc, char** argv);

}  // namespace sightline
