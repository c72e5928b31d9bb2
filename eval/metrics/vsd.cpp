// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/metrics/vsd.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>

namespace sightline {

cv::Mat distances_of_depth(const cv::Mat& depth, const Eigen::Matrix3d& k) {
  cv::Mat distances(depth.size(), CV_64F);
  for (int v = 0; v < depth.rows; ++v) {
    const double y = (v - k(1, 2)) / k(1, 1);
    const double* from = depth.ptr<double>(v);
    double* to = distances.ptr<double>(v);
    for (int u = 0; u < depth.cols; ++u) {
      const double x = (u - k(0, 2)) / k(0, 0);
      to[u] = from[u] * std::sqrt(x * x + y * y + 1);
    }
  }
  return distances;
}

std::vector<double> vsd(const cv::Mat& test_mm, const cv::Mat& truth_mm,
                        const cv::Mat& estimated_mm, double delta_mm,
                        std::span<const double> taus_mm) {
  int in_either = 0;
  std::vector<double> differences;  // where both are visible
  for (int v = 0; v < test_mm.rows; ++v) {
    const double* test = test_mm.ptr<double>(v);
    const double* truth = truth_mm.ptr<double>(v);
    const double* estimated = estimated_mm.ptr<double>(v);
    for (int u = 0; u < test_mm.cols; ++u) {
      const auto is_before = [&](double model) {
        return model > 0 && (test[u] == 0 || model - test[u] <= delta_mm);
      };
      const bool is_true = is_before(truth[u]);
      const bool is_estimated = is_before(estimated[u]) || (is_true && estimated[u] > 0);
      if (is_true || is_estimated) ++in_either;
      if (is_true && is_estimated) differences.push_back(std::abs(truth[u] - estimated[u]));
    }
  }
  std::vector<double> errors;
  for (const double tau_mm : taus_mm) {
    const auto good = std::count_if(differences.begin(), differences.end(),
                                    [tau_mm](double difference) { return difference < tau_mm; });
    errors.push_back(in_either == 0 ? 1 : static_cast<double>(in_either - good) / in_either);
  }
  return errors;
}

}  // namespace sightline
