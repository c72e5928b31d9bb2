// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

#include "eval/datasets/bop/mask_runs.h"
#include "eval/datasets/sightings.h"
#include "eval/records/names.h"
#include "renderer/frame.h"

namespace sightline {

/// An image of a data set in place of a rendered one.
struct SetFrame {
  Scene scene;  ///< target, camera, pose and bits alone: nobody knows the rest
  Frame frame;
  std::optional<EstimateOutcome> problem;  ///< why there is none
};

/// What was read last of a set's files: the instances of an image, and the conditions of a sweep,
/// follow one another and share its picture and, in BOP's imagewise format, its file of masks; the
/// conditions of an instance its mask as well.
class SetFiles {
 public:
  /// As read_picture has it. A copy: whoever draws into it leaves the next reader's as it is.
  cv::Mat picture(const std::filesystem::path& file);
  /// The mask of what is seen of a sighting's instance, not 0 there; empty where it cannot be read.
  /// It is not to be drawn into.
  cv::Mat visible_mask(const Sighting& sighting);

 private:
  std::filesystem::path picture_file_;
  cv::Mat picture_;
  std::filesystem::path mask_file_;
  cv::Mat mask_;
  std::filesystem::path masks_file_;
  std::optional<MaskRuns> masks_;
};

/// A line where the first picture has 16 bits, of which its brightest pixel leaves four or more of
/// `bits` unused: extractors would see next to nothing. Empty where that is not so.
std::string note_on_bits(std::span<const Sighting> sightings, int bits);

/// Reads the picture of a sighting as grey levels, as they are stored, and states the truth that
/// its pose tells: pixels, depth and ids of the target's mesh alone. Where the set has a mask of
/// what is seen of the instance, what it leaves out belongs to another body, and a feature with
/// none of it within two pixels is hidden.
/// `files` spares reading the same twice.
SetFrame read_set_frame(const std::shared_ptr<const Target>& target, int bits,
                        const Sighting& sighting, SetFiles& files);
SetFrame read_set_frame(const std::shared_ptr<const Target>& target, int bits,
                        const Sighting& sighting);

}  // namespace sightline
