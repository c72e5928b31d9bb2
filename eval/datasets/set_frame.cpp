// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/set_frame.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "eval/datasets/pictures.h"
#include "renderer/truth.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

constexpr int kNearPx = 2;         // masks of other programs differ by about a pixel
constexpr uint8_t kOtherBody = 2;  // index of the body plus one, as Frame::body_ids has them

// Takes from the target what the mask of its visible pixels leaves out.
void hide_behind_others(const cv::Mat& visible_mask, Frame& frame) {
  cv::Mat near_visible;
  const cv::Size size(2 * kNearPx + 1, 2 * kNearPx + 1);
  cv::dilate(visible_mask != 0, near_visible, cv::getStructuringElement(cv::MORPH_RECT, size));
  frame.body_ids.setTo(kOtherBody, (frame.body_ids != 0) & (near_visible == 0));
  BodyTruth& truth = frame.truth.bodies.front();
  truth.visible_box = cv::boundingRect(frame.body_ids == 1);
  truth.visible_pixels = cv::countNonZero(frame.body_ids == 1);
  for (FeatureTruth& feature : truth.features) {
    if (!feature.is_in_image) continue;
    const int u = static_cast<int>(std::lround(feature.pixel.x()));
    const int v = static_cast<int>(std::lround(feature.pixel.y()));
    feature.is_hidden_by_other = near_visible.at<uint8_t>(v, u) == 0;
    feature.is_visible = feature.is_visible && !feature.is_hidden_by_other;
  }
}

}  // namespace

cv::Mat SetFiles::picture(const std::filesystem::path& file) {
  if (picture_.empty() || file != picture_file_) {
    picture_ = read_picture(file);
    picture_file_ = file;
  }
  return picture_.clone();
}

cv::Mat SetFiles::visible_mask(const Sighting& sighting) {
  const std::filesystem::path& file = sighting.visible_mask;
  if (input_ending(file) != ".json") {
    if (mask_.empty() || file != mask_file_) {
      mask_ = read_grey_picture(file);
      mask_file_ = file;
    }
    return mask_;
  }
  if (!masks_ || file != masks_file_) {
    masks_.emplace(file);
    masks_file_ = file;
  }
  return masks_->mask(sighting.gt_id);
}

std::string note_on_bits(std::span<const Sighting> sightings, int bits) {
  constexpr int kUnused = 4;
  for (const Sighting& sighting : sightings) {
    const cv::Mat grey = read_grey_picture(sighting.picture);
    if (grey.empty()) continue;
    double brightest = 0;
    cv::minMaxLoc(grey, nullptr, &brightest);
    const int used = std::bit_width(static_cast<unsigned>(brightest));
    if (grey.depth() != CV_16U || brightest == 0 || bits - used < kUnused) return "";
    return fmt::format(
        "{}: has 16 bits and no grey level over {}, where white is taken to be {}: if white is "
        "less, say --set dataset.bits={}",
        sighting.picture.string(), brightest, (1 << bits) - 1, std::max(used, 8));
  }
  return "";
}

SetFrame read_set_frame(const std::shared_ptr<const Target>& target, int bits,
                        const Sighting& sighting) {
  SetFiles files;
  return read_set_frame(target, bits, sighting, files);
}

SetFrame read_set_frame(const std::shared_ptr<const Target>& target, int bits,
                        const Sighting& sighting, SetFiles& files) {
  SetFrame out;
  Scene& scene = out.scene;
  scene.target = target;
  scene.camera = sighting.camera;
  scene.cam_from_target = sighting.cam_from_target;
  if (sighting.problem) {
    out.problem = sighting.problem;
    return out;
  }
  const cv::Mat picture = files.picture(sighting.picture);
  out.frame.image = grey_of(picture);
  if (!out.frame.image.empty() && picture.channels() == 3) out.frame.colour = picture;
  if (out.frame.image.empty()) {
    out.problem = EstimateOutcome::kPictureUnreadable;
    return out;
  }
  scene.camera.width_px = out.frame.image.cols;
  scene.camera.height_px = out.frame.image.rows;
  scene.sensor.bits = out.frame.image.depth() == CV_8U ? 8 : bits;
  if (!why_not_imageable(scene).empty()) {
    out.problem = EstimateOutcome::kNotImaged;
    return out;
  }
  TextureCache textures;
  state_truth(scene, textures, out.frame);
  if (sighting.visible_mask.empty()) return out;
  const cv::Mat mask = files.visible_mask(sighting);
  if (mask.size() == out.frame.image.size()) {
    hide_behind_others(mask, out.frame);
  } else {
    out.problem = EstimateOutcome::kMaskUnreadable;
  }
  return out;
}

}  // namespace sightline
