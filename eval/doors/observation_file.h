// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Observations that somebody else's extractor made: a CSV file, or the keypoint results of COCO,
// which keypoint networks write.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Core>

#include "eval/doors/shown_pictures.h"
#include "eval/doors/trial_extractor.h"
#include "scenes/scene/keys.h"

namespace sightline {

enum class ObservationFormat { kByEnding, kCsv, kCoco };

/// Where a file's pixels are counted from.
enum class PixelOrigin {
  kCentres,     ///< the top-left pixel's centre is (0, 0), as ours
  kCorners,     ///< its corner is (0, 0), its centre (0.5, 0.5)
  kNormalised,  ///< the same, over the picture's width and height (YOLO-pose)
};

/// What a study says of a file of observations: a table of [[observations]].
struct ObservationSource {
  std::string name;  ///< of the extractor
  std::filesystem::path file;
  ObservationFormat format = ObservationFormat::kByEnding;  ///< .json: COCO, anything else: CSV
  PixelOrigin pixels = PixelOrigin::kCentres;
  std::filesystem::path images;  ///< COCO annotations that say which image an id is; may be empty
  double least_confidence = 0;   ///< what is less sure is not taken
};

std::vector<Key> keys_of(ObservationSource& source);

/// What a file says of one feature in one picture.
struct GivenObservation {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< pixel centres at integers
  std::optional<Eigen::Matrix2d> covariance_px2;
};

/// What a file says of one instance of the target, by the index of the target's feature.
using GivenFeatures = std::map<int, GivenObservation>;

/// What a file says of the pictures of a study, by scene, image and instance.
using GivenObservations = std::map<std::tuple<int, int64_t, int>, GivenFeatures>;

/// Reads a file of observations. CSV: scene_id,im_id[,gt_id],feature,u,v[,sigma |
/// ,var_uu,var_uv,var_vv][,confidence], a row a feature that was found; gt_id may be left out where
/// no picture has several instances. COCO: detections of one category with a keypoint (x, y, score)
/// for each of the target's features in their order, or in that of the category's names in
/// `images`; the surest detection of a picture counts, of several instances for the one that it is
/// nearest to. Without `images` an image_id is BOP's im_id in the only scene. Throws InputError,
/// with file and row, for whatever is not so, for features and pictures that there are not, and for
/// two rows of one feature.
GivenObservations read_observations(const ObservationSource& source, const ShownPictures& pictures);

/// The standard deviation of the noise of each coordinate of those observations that are no
/// outliers, from their squared distances from the truth (px^2), when inliers are Gaussian and the
/// majority: a mean over those within kInlierSigmas, corrected for what that cuts off. 0 for an
/// empty list.
double inlier_sigma_px(std::vector<double> squared_errors_px2);

/// An extractor that finds what a file of observations says. Observations without a covariance get
/// one of the noise that the file's own inliers show against the truth, which its summary says.
TrialExtractor recorded_extractor(const ObservationSource& source, const ShownPictures& pictures);

}  // namespace sightline
