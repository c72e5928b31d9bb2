// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The one error of the BOP challenge that is of images (Hodan et al., "BOP: Benchmark for 6D Object
// Pose Estimation", ECCV 2018).
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace sightline {

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
