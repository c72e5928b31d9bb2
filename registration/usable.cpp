// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/usable.h"

#include <algorithm>

#include <fmt/format.h>

namespace sightline {
namespace {

constexpr double kLeastOutlinePx = 100;
constexpr double kLeastUnclipped = 0.1;  // of the outline

bool is_behind(const Mesh& mesh, const Pose& pose) {
  return std::any_of(mesh.vertices.begin(), mesh.vertices.end(),
                     [&](const Eigen::Vector3d& vertex) { return !((pose * vertex).z() > 0); });
}

bool reaches_border(const BasisImages& images, const Camera& camera) {
  const cv::Rect& box = images.box;
  return box.x <= 0 || box.y <= 0 || box.x + box.width >= camera.width_px ||
         box.y + box.height >= camera.height_px;
}

// The length of the outline where pixels are not clipped, px.
double unclipped_outline(const ModelView& view, const cv::Mat& is_clipped) {
  double sum = 0;
  for (int y = 0; y < view.box.height; ++y) {
    const float* const outline = view.outline.ptr<float>(y);
    const uchar* const clipped = is_clipped.ptr<uchar>(y + view.box.y) + view.box.x;
    for (int x = 0; x < view.box.width; ++x) sum += clipped[x] == 0 ? outline[x] : 0;
  }
  return sum;
}

}  // namespace

Usability usability(const RegistrationTask& task, const GreyImage& image) {
  constexpr int kFactor = 4;  // what is small on the shrunk image is too small anyway
  constexpr double kBlurPx = 0.5;
  const Pose& pose = task.prior.cam_from_target;
  if (is_behind(task.mesh, pose)) {
    return {RegistrationStatus::kBehindCamera,
            "at the prior the target is not wholly in front of the camera"};
  }
  const GreyImage small = shrunk(image, kFactor);
  BasisDrawer drawer(task.mesh, small.camera);
  BasisOptions options;
  options.margin_px = margin_px(kBlurPx);
  const auto images = drawer.draw(pose, options);
  if (!images) {
    return {RegistrationStatus::kOutside, "the prior expects the target outside the image"};
  }
  const ModelView view = model_view(*images, kBlurPx, RegistrationRegion::kImage);
  const double outline_px =
      kFactor * unclipped_outline(view, cv::Mat::zeros(small.grey.size(), CV_8U));
  if (outline_px < kLeastOutlinePx) {
    const bool is_cut = reaches_border(*images, small.camera);
    return {is_cut ? RegistrationStatus::kOutside : RegistrationStatus::kTooSmall,
            fmt::format("{:.0f} px of the target's outline are in the image, at least {:.0f} are "
                        "needed",
                        outline_px, kLeastOutlinePx)};
  }
  const double unclipped_px = kFactor * unclipped_outline(view, small.is_clipped);
  if (unclipped_px < std::max(kLeastOutlinePx, kLeastUnclipped * outline_px)) {
    return {RegistrationStatus::kSaturated,
            fmt::format("of {:.0f} px of the target's outline the sensor is at white along all but "
                        "{:.0f}",
                        outline_px, unclipped_px)};
  }
  return {};
}

}  // namespace sightline
