// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The pose errors of the BOP challenge, as it defines them (Hodan et al., "BOP: Benchmark for 6D
// Object Pose Estimation", ECCV 2018; "BOP Challenge 2020", ECCVW 2020, section 2.2), millimetres
// and pixels. All poses are cam_from_model.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "pose/pose.h"

namespace sightline {

/// Maximum symmetry-aware surface distance: the greatest distance of a vertex in the two poses, at
/// the symmetry of the true one that makes it least.
double mssd_mm(const Eigen::Matrix3Xd& points_mm, const Pose& estimated, const Pose& truth,
               std::span<const Pose> symmetries);

/// The true pose at the symmetry that mssd_mm finds.
Pose nearest_alike(const Eigen::Matrix3Xd& points_mm, const Pose& estimated, const Pose& truth,
                   std::span<const Pose> symmetries);

/// Maximum symmetry-aware projection distance: the same of the vertices' pixels. Points behind the
/// camera are projected like others, as the challenge does it; infinite where one is in its plane.
double mspd_px(const Eigen::Matrix3Xd& points_mm, const Eigen::Matrix3d& k, const Pose& estimated,
               const Pose& truth, std::span<const Pose> symmetries);

/// Average distance of the vertices (Hinterstoisser et al., ACCV 2012).
double add_mm(const Eigen::Matrix3Xd& points_mm, const Pose& estimated, const Pose& truth);

/// Average distance of the true vertices from the nearest estimated one, for symmetric objects
/// (ibid.; also called ADD-S).
double adi_mm(const Eigen::Matrix3Xd& points_mm, const Pose& estimated, const Pose& truth);

// Of other benchmarks.

/// Average distance of the vertices' pixels (Brachmann et al., CVPR 2016: "2D projection", good
/// below 5 px). MSPD is the greatest instead.
double projection_px(const Eigen::Matrix3Xd& points_mm, const Eigen::Matrix3d& k,
                     const Pose& estimated, const Pose& truth);

/// Whether the attitude errs by less than 5 degrees and the position by less than 5 cm (Shotton et
/// al., CVPR 2013).
bool is_within_5deg_5cm(const Pose& estimated, const Pose& truth);

/// The score of ESA's Pose Estimation Challenge (Kisantal et al., "Satellite Pose Estimation
/// Challenge", IEEE TAES 2020): the geodesic angle in radians plus the distance of the positions
/// over the true one's length.
double speed_score(const Pose& estimated, const Pose& truth);

/// The same of the challenge of 2021, SPEED+: an angle below 0.169 degrees and a distance below
/// 2.173 parts in a thousand count as zero, each for itself: what its hardware is calibrated to
/// (Park et al., "SPEED+", 2022).
double speed_plus_score(const Pose& estimated, const Pose& truth);

/// Distances from the camera's centre of a depth image (CV_64F, z); 0 stays 0.
cv::Mat distances_of_depth(const cv::Mat& depth, const Eigen::Matrix3d& k);

/// Visible surface discrepancy, one a tau: the part of the pixels, visible in either pose, that are
/// not visible in both or whose distances differ by tau or more. All images are distances in mm
/// (CV_64F, of one size, 0 is nothing): the test image's, the model's in the true and in the
/// estimated pose. A pixel of the model is visible where the test image has no distance or one that
/// is at most `delta_mm` less; of the estimate, also where the true one is. 1 where neither is.
std::vector<double> vsd(const cv::Mat& test_mm, const cv::Mat& truth_mm,
                        const cv::Mat& estimated_mm, double delta_mm,
                        std::span<const double> taus_mm);

}  // namespace sightline
