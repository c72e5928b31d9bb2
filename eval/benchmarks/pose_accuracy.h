// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How often a pose solver is right, and whether it knows, over many draws.
#pragma once

namespace sightline {

/// `sightline_bench accuracy [key=value ...]` prints a table: of each cell (points / outliers in %,
/// solid or planar target, noise told or not) the share of right answers, the ratio of the errors
/// to those of least squares on the true inliers, the mean NEES, the wrong answers that nothing
/// flags (of 1000), those that have the truth as the second pose, those that have more evidence
/// than the truth's own mode (by consensus: "beaten", what no search can mend), and the CPU time.
/// Keys:
///   solver=consensus   names of pose solvers, or of ours and the comparator, with commas
///   cells=8/50,12/70   points / share of outliers in %
///   draws=1000         of each cell; fewer from 1000 points on (a fifth)
///   seed=1
///   outliers=anywhere  uniform over the image; or "near": Gaussian, 20 px
///   noise_px=1
///   start=free         or "prior": the truth turned by 3 degrees and moved by 2 %
/// The exit code is 2 for a key or value that it does not know.
int run_pose_accuracy(int argc, char** argv);

}  // namespace sightline
