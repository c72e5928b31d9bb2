// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/shown_pictures.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sightline {

ShownPictures::ShownPictures(const Target& target, std::vector<ShownTarget> shown,
                             std::function<bool(PictureName)> has_picture)
    : target_(target), shown_(std::move(shown)), has_picture_(std::move(has_picture)) {
  std::stable_sort(shown_.begin(), shown_.end(), [](const ShownTarget& a, const ShownTarget& b) {
    return std::tie(a.picture, a.gt_id) < std::tie(b.picture, b.gt_id);
  });
}

std::span<const ShownTarget> ShownPictures::in(PictureName picture) const {
  struct ByPicture {
    bool operator()(const ShownTarget& a, PictureName b) const { return a.picture < b; }
    bool operator()(PictureName a, const ShownTarget& b) const { return a < b.picture; }
  };
  const auto [begin, end] = std::equal_range(shown_.begin(), shown_.end(), picture, ByPicture{});
  return {begin, end};
}

std::string ShownPictures::why_not(PictureName picture) const {
  if (!in(picture).empty() || has_picture_(picture)) return "";
  const std::vector<int> there = scenes();
  if (std::find(there.begin(), there.end(), picture.scene_id) == there.end()) {
    return fmt::format("is about scene {}, must be about scene {}", picture.scene_id,
                       fmt::join(there, ", "));
  }
  return fmt::format("is about image {} of scene {}, which the set does not have", picture.im_id,
                     picture.scene_id);
}

std::vector<int> ShownPictures::scenes() const {
  std::vector<int> scenes;
  for (const ShownTarget& shown : shown_) {
    if (scenes.empty() || scenes.back() != shown.picture.scene_id) {
      scenes.push_back(shown.picture.scene_id);
    }
  }
  return scenes;
}

std::optional<Eigen::Vector2d> true_pixel(const ShownTarget& shown, const TargetFeature& feature) {
  return project(shown.camera, shown.cam_from_target * feature.position_m);
}

}  // namespace sightline
