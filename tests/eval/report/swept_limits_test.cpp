// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the report states of a limit that the study sweeps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/report/figures.h"
#include "eval/report/panels.h"
#include "eval/study/study_file.h"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

Study study_with(const std::string& setting) {
  return read_study("outlier-impact", {.trials = 1, .seed = {}, .set = {setting}});
}

std::string provenance_of(const Study& study) {
  const Summary summary;
  return provenance_figure({study, summary, {}, {}, {}});
}

TEST(SweptLimits, AreStatedAsSwept) {
  const Study study = study_with("sweep={'extraction.outlier_px'=[8, 2, 5]}");
  EXPECT_EQ(outlier_limit_px(*study.images()), "the swept 2, 5 or 8");
  EXPECT_THAT(provenance_of(study), HasSubstr("farther than the swept 2, 5 or 8 px from where"));
}

TEST(SweptLimits, AreOneNumberWhereTheyAreNotSwept) {
  const Study study = study_with("sweep={'extraction.passes'=[1, 2]}");
  EXPECT_EQ(outlier_limit_px(*study.images()), "3");
  EXPECT_THAT(provenance_of(study), HasSubstr("farther than 3 px from where"));
  EXPECT_THAT(provenance_of(study), Not(HasSubstr("swept 3")));
}

}  // namespace
}  // namespace sightline
