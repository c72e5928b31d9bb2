// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/measures.h"

#include <array>
#include <numbers>

#include "eval/metrics/pose_errors.h"
#include "eval/records/caps.h"
#include "pose/attitude.h"

namespace sightline {
namespace {

constexpr double kDegreesARad = 180 / std::numbers::pi;
constexpr double kGoodProjectionPx = 5;
constexpr bool kFromPosesAlone = false;  // needs no model

const BopPair* chosen_pair(const BopTarget& target) {
  return target.chosen ? &target.pairs[*target.chosen] : nullptr;
}

bool has_good_projection(const BopTarget& target) {
  const BopPair* pair = chosen_pair(target);
  return pair != nullptr && pair->projection_px < kGoodProjectionPx;
}

bool has_5deg_5cm(const BopTarget& target) {
  const BopPair* pair = chosen_pair(target);
  return pair != nullptr && pair->within_5deg_5cm == 1;
}

constexpr std::array kPairMeasures = {
    PairMeasure{"mssd_mm", &BopPair::mssd_mm,
                [](const PairPoses& p) { return mssd(p.points_mm, p.estimated, p.alike); }},
    PairMeasure{"mspd_px", &BopPair::mspd_px,
                [](const PairPoses& p) {
                  return mspd_px(p.points_mm, p.k, p.estimated, p.truth, p.symmetries);
                }},
    PairMeasure{"add_mm", &BopPair::add_mm,
                [](const PairPoses& p) { return add_distance(p.points_mm, p.estimated, p.truth); }},
    PairMeasure{"adi_mm", &BopPair::adi_mm,
                [](const PairPoses& p) { return adi_distance(p.points_mm, p.estimated, p.truth); }},
    PairMeasure{"theta_error_deg", &BopPair::theta_error_deg,
                [](const PairPoses& p) {
                  return kDegreesARad * attitude_error_rad(p.estimated.rotation, p.alike.rotation);
                },
                kFromPosesAlone},
    PairMeasure{"t_error_percent", &BopPair::t_error_percent,
                [](const PairPoses& p) {
                  return 100 *
                         translation_error_fraction(p.estimated.translation, p.alike.translation);
                },
                kFromPosesAlone},
    PairMeasure{"geodesic_deg", &BopPair::geodesic_deg,
                [](const PairPoses& p) {
                  return kDegreesARad * geodesic_angle_rad(p.estimated.rotation, p.alike.rotation);
                },
                kFromPosesAlone},
    PairMeasure{
        "projection_px", &BopPair::projection_px,
        [](const PairPoses& p) { return projection_px(p.points_mm, p.k, p.estimated, p.alike); }},
    PairMeasure{"speed_score", &BopPair::speed_score,
                [](const PairPoses& p) { return speed_score(p.estimated, p.alike); },
                kFromPosesAlone},
    PairMeasure{"speed_plus_score", &BopPair::speed_plus_score,
                [](const PairPoses& p) { return speed_plus_score(p.estimated, p.alike); },
                kFromPosesAlone},
    PairMeasure{
        "is_within_5deg_5cm", &BopPair::within_5deg_5cm,
        [](const PairPoses& p) { return is_within_5deg_5cm(p.estimated, p.alike) ? 1.0 : 0.0; },
        kFromPosesAlone},
};

constexpr std::array<SummaryMeasure, 9> kSummaryMeasures = {
    RecallMeasure{"add_recall", "ADD < 0.1 d", "ADD", &BopSummary::add,
                  [](const BopTarget& target) { return target.is_add_good; }},
    RecallMeasure{"adi_recall", "ADI < 0.1 d", "ADI", &BopSummary::adi,
                  [](const BopTarget& target) { return target.is_adi_good; }},
    ErrorMeasure{"theta_error_deg", "theta_error / °", "θ error, °", &BopSummary::theta_error_deg,
                 &BopPair::theta_error_deg, kAngleCapDeg, "theta", Told::kMedian},
    ErrorMeasure{"t_error_percent", "T_error / %", "T error, %", &BopSummary::t_error_percent,
                 &BopPair::t_error_percent, kTranslationCapPercent, "t", Told::kMedian},
    ErrorMeasure{"geodesic_deg", "geodesic / °", "geodesic, °", &BopSummary::geodesic_deg,
                 &BopPair::geodesic_deg, kAngleCapDeg, "geodesic", Told::kMedian},
    RecallMeasure{"projection_5px_recall", "2D proj. < 5 px", "2D projection",
                  &BopSummary::projection_5px, has_good_projection},
    RecallMeasure{"within_5deg_5cm", "5 deg 5 cm", "5° 5 cm", &BopSummary::within_5deg_5cm,
                  has_5deg_5cm, kFromPosesAlone},
    ErrorMeasure{"speed_score", "SPEED", "SPEED", &BopSummary::speed_score, &BopPair::speed_score,
                 kSpeedScoreCap, "speed", Told::kMean},
    ErrorMeasure{"speed_plus_score", "SPEED+", "SPEED+", &BopSummary::speed_plus_score,
                 &BopPair::speed_plus_score, kSpeedScoreCap, "speed+", Told::kMean},
};

}  // namespace

std::span<const PairMeasure> pair_measures() {
  return kPairMeasures;
}

std::span<const SummaryMeasure> summary_measures() {
  return kSummaryMeasures;
}

}  // namespace sightline
