// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The search for poses that explain many points: poses of three points each, screened, scored, and
// the best of them fitted.
#pragma once

#include "pose/consensus/cloud.h"
#include "pose/consensus/modes.h"

namespace sightline::consensus {

struct Found {
  ModeList modes;
  int triples = 0;  ///< how many were tried
  int fits = 0;
};

/// All triples of up to twelve points; drawn ones (a counter hashed: the same problem gives the
/// same triples) where there are more, until a mode of more inliers than the best would have been
/// met with a probability of 0.999, and at most kMostTriples. An initial pose is one more
/// hypothesis.
///
/// More than 32 points are screened first: a hypothesis is dropped as soon as the points within a
/// wide radius are too few to be those of a pose of the consensus that is looked for (Wald's
/// sequential test, as in Matas and Chum, "Randomized RANSAC with sequential probability ratio
/// test", ICCV 2005).
Found search(const Cloud& cloud);

inline constexpr int kMostTriples = 200000;

}  // namespace sightline::consensus
