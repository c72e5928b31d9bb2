// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The outcomes and labels that records bear, and the names under which tables, stores and CSV files
// know them. Each enum has its names in one array, in the order of its values.
#pragma once

#include <array>
#include <concepts>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace sightline {

/// What became of one feature in one trial: found, or why it was not.
enum class ObservationOutcome {
  kFound,
  kHidden,  ///< this and the next ones: see ObservationStatus in features/observation.h
  kOutsideImage,
  kWindowTooSmall,
  kSaturated,
  kEmptyWindow,
  kNoOutline,
  kTooFewEdgePixels,
  kParallelLines,
  kOutsideWindow,
  kNoCorner,
  kMissing,  ///< a guest says nothing of it, or a numeric study left it out
};
inline constexpr std::array<std::string_view, 12> kObservationOutcomes = {
    "found",
    "hidden",
    "outside the image",
    "window too small",
    "saturated window",
    "empty window",
    "no outline to look for",
    "too few edge pixels",
    "parallel lines",
    "lines meet outside the window",
    "no corner",
    "missing"};

/// Whether a solver or a method had a pose, or why there is none.
enum class EstimateOutcome {
  kOk,
  kTooFewPoints,  ///< this and the next ones: see PoseStatus and OrientationStatus in pose/
  kDegenerate,
  kBehindCamera,
  kDiverged,
  kNotFinite,
  kBadWeights,
  kReflection,
  kNotConverged,
  kNotImaged,          ///< the target is not wholly in the image: no solver was asked
  kNoPrior,            ///< no prior pose could be drawn, or none was given
  kPictureUnreadable,  ///< of a data set
  kMaskUnreadable,     ///< of a data set, or its size is not the picture's
  // Of guests: see eval/doors/.
  kNoEstimate,   ///< its file has none for the trial, or it says that it has none
  kNotRigid,     ///< what it gave is no rotation and translation of finite numbers
  kTimedOut,     ///< it did not answer in time
  kCrashed,      ///< its process ended
  kGarbled,      ///< its answer is none by the protocol
  kRaisedError,  ///< it says that it failed
  kNoTruth,      ///< of a data set: what it gives as the true pose is none
  // Of the registration: see RegistrationStatus.
  kTargetOutside,
  kTargetTooSmall,
  kTargetSaturated,
  kNotTrusted,
  kTooManyPoints,  ///< see PoseStatus
};
inline constexpr std::array<std::string_view, 25> kEstimateOutcomes = {"ok",
                                                                       "too_few_points",
                                                                       "degenerate",
                                                                       "behind_camera",
                                                                       "diverged",
                                                                       "not_finite",
                                                                       "bad_weights",
                                                                       "reflection",
                                                                       "not_converged",
                                                                       "not imaged",
                                                                       "no prior",
                                                                       "picture unreadable",
                                                                       "mask unreadable",
                                                                       "no estimate",
                                                                       "not rigid",
                                                                       "timed out",
                                                                       "process ended",
                                                                       "answer unreadable",
                                                                       "raised an error",
                                                                       "no true pose",
                                                                       "target outside",
                                                                       "target too small",
                                                                       "target saturated",
                                                                       "not trusted",
                                                                       "too_many_points"};

/// What an observation is, held against the truth. Tables list labels in this order.
enum class ObservationLabel {
  kInlier,             ///< found where the feature is
  kWrongLine,          ///< a line was taken that is no edge of the feature
  kWrongIntersection,  ///< both lines are edges of the feature, but meet far from it
  kWrongPoint,         ///< another point of the target was taken for it
  kClutter,            ///< what was taken is not of the target: background or another body
  kHidden,             ///< something was found, though the feature is not to be seen
  kMissing,            ///< nothing was found, though the feature is to be seen
  kAbsent,             ///< nothing was found, and nothing is to be seen
  kPlanted,            ///< displaced on purpose by a numeric study
};
inline constexpr std::array<std::string_view, 9> kObservationLabels = {
    "inlier", "wrong line", "wrong intersection", "wrong point", "clutter", "hidden", "missing",
    "absent", "planted"};

/// What a line observation is, held against the truth.
enum class LineLabel {
  kRight,  ///< the image of its edge, within the study's limits
  kWrong,
};
inline constexpr std::array<std::string_view, 2> kLineLabels = {"right line", "wrong line"};

/// The names of an enum's values; the argument says which enum.
constexpr std::span<const std::string_view> names_of(ObservationOutcome) {
  return kObservationOutcomes;
}
constexpr std::span<const std::string_view> names_of(EstimateOutcome) {
  return kEstimateOutcomes;
}
constexpr std::span<const std::string_view> names_of(ObservationLabel) {
  return kObservationLabels;
}
constexpr std::span<const std::string_view> names_of(LineLabel) {
  return kLineLabels;
}

static_assert(kObservationOutcomes.size() == static_cast<size_t>(ObservationOutcome::kMissing) + 1);
static_assert(kEstimateOutcomes.size() == static_cast<size_t>(EstimateOutcome::kTooManyPoints) + 1);
static_assert(kObservationLabels.size() == static_cast<size_t>(ObservationLabel::kPlanted) + 1);

static_assert(kLineLabels.size() == static_cast<size_t>(LineLabel::kWrong) + 1);

/// An enum of this file.
template <typename Enum>
concept Named = requires(Enum value) {
  { names_of(value) } -> std::same_as<std::span<const std::string_view>>;
};

/// A text that is no name of a value. what() says what was read and what is known.
class UnknownName : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <Named Enum>
constexpr std::string_view to_string(Enum value) {
  return names_of(value)[static_cast<size_t>(value)];
}

/// The value of that name. Throws UnknownName.
template <Named Enum>
Enum from_string(std::string_view text) {
  const std::span<const std::string_view> names = names_of(Enum{});
  std::string known;
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i] == text) return static_cast<Enum>(i);
    known.append(i == 0 ? "" : ", ").append(names[i]);
  }
  throw UnknownName("'" + std::string(text.substr(0, 40)) + "' is none of " + known);
}

}  // namespace sightline
