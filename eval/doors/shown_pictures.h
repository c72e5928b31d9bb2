// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "eval/doors/trial_name.h"
#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/target/target.h"

namespace sightline {

/// The target as a picture of a study shows it.
struct ShownTarget {
  PictureName picture;
  int gt_id = 0;
  std::string image;  ///< the picture's path within its data set; empty where it is rendered
  Camera camera;
  Pose cam_from_target;
};

/// The pictures of a study: what files of others can be about.
class ShownPictures {
 public:
  /// `has_picture` says of a picture that shows no such target whether it is there all the same:
  /// then what files say of it does not count; otherwise it is a mistake.
  ShownPictures(const Target& target, std::vector<ShownTarget> shown,
                std::function<bool(PictureName)> has_picture);

  const Target& target() const { return target_; }
  /// In the order of pictures.
  std::span<const ShownTarget> all() const { return shown_; }
  /// What one picture shows: none, one or several instances of the target.
  std::span<const ShownTarget> in(PictureName picture) const;
  /// Why nothing can be said of such a picture; empty where something can.
  std::string why_not(PictureName picture) const;
  /// The numbers of the scenes that there are.
  std::vector<int> scenes() const;

 private:
  const Target& target_;
  std::vector<ShownTarget> shown_;
  std::function<bool(PictureName)> has_picture_;
};

/// Where the target's feature truly is; none where the camera cannot see such a point.
std::optional<Eigen::Vector2d> true_pixel(const ShownTarget& shown, const TargetFeature& feature);

}  // namespace sightline
