// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/robust_alignment.h"

#include <array>

#include "pose/orientation/robust_methods.h"

namespace sightline {
namespace {

constexpr std::array kRobustCatalogue = {
    RobustAlignmentMethod{"consensus",
                          "every pair weighed by its probability to be right, found by distances",
                          align_by_consensus},
    RobustAlignmentMethod{"orpe", "the most pairs whose largest distance noise explains (minimax)",
                          align_by_orpe},
    RobustAlignmentMethod{"ransac_umeyama", "random triples, Umeyama's method, the most agreeing",
                          align_by_ransac_umeyama},
};

std::vector<Eigen::Vector3d> taken_to_double(std::span<const Eigen::Vector3f> points) {
  std::vector<Eigen::Vector3d> result;
  result.reserve(points.size());
  for (const Eigen::Vector3f& x : points) result.push_back(x.cast<double>());
  return result;
}

}  // namespace

std::span<const RobustAlignmentMethod> robust_alignment_methods() {
  return kRobustCatalogue;
}

const RobustAlignmentMethod* find_robust_alignment_method(std::string_view name) {
  for (const RobustAlignmentMethod& method : kRobustCatalogue) {
    if (method.name == name) return &method;
  }
  return nullptr;
}

RobustAlignment align_with_outliers(const MatchedPoints& points,
                                    const RobustAlignmentOptions& options) {
  return align_by_consensus(points, options);
}

RobustAlignment align_with_outliers(std::span<const Eigen::Vector3f> points_in_a,
                                    std::span<const Eigen::Vector3f> points_in_b,
                                    std::span<const double> weights,
                                    const RobustAlignmentOptions& options) {
  const std::vector<Eigen::Vector3d> in_a = taken_to_double(points_in_a);
  const std::vector<Eigen::Vector3d> in_b = taken_to_double(points_in_b);
  return align_by_consensus({in_a, in_b, weights}, options);
}

}  // namespace sightline
