// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// COCO's annotations of objects with keypoints, as text (Lin et al., ECCV 2014, and
// https://cocodataset.org/#format-data). Keypoints have pixel centres at integers, as ours and as
// Detectron2 takes them (it adds the 0.5 of its own convention); boxes are of whole pixels from
// corner to corner, so that the pixel (0, 0) alone has the box [0, 0, 1, 1].
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "eval/output/json.h"

namespace sightline::coco {

/// A kind of object. Its skeleton, which only drawings use, is empty.
struct Category {
  int64_t id = 0;
  std::string name;
  std::vector<std::string> keypoints;  ///< their names, in the order of every annotation
};

/// COCO's v of a keypoint.
enum class Labelled { kNot = 0, kHidden = 1, kVisible = 2 };

struct Keypoint {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Labelled labelled = Labelled::kNot;  ///< where kNot, COCO has no pixel either: (0, 0)
};

/// An object in an image.
struct Annotation {
  int64_t image_id = 0;
  int64_t category_id = 0;
  cv::Rect box;      ///< of its visible pixels
  int64_t area = 0;  ///< how many they are
  Json segmentation;
  std::vector<Keypoint> keypoints;  ///< in the order of the category
};

/// "segmentation" of a mask (CV_8U, 0 is background) as run lengths, uncompressed: of the pixels
/// column by column, how many are background, how many not, and so on.
Json run_lengths(const cv::Mat& mask);

Json category_entry(const Category& category);
Json image_entry(int64_t id, const std::string& file_name, const cv::Size& size);
/// `id` counts from 1 within a file: pycocotools takes 0 for "no match".
Json annotation_entry(int64_t id, const Annotation& annotation);

/// A file of annotations, an entry a line.
std::string annotation_file(const Json& info, std::span<const Json> categories,
                            std::span<const Json> images, std::span<const Json> annotations);

}  // namespace sightline::coco
