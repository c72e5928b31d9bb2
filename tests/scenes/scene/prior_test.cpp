// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/prior.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

TEST(Prior, AFileStatesTheRangeInPercent) {
  const PriorError given = read_prior(TomlTable::read_text("range_percent = 5", "prior.toml"));
  EXPECT_EQ(given.range_fraction, 0.05);
  EXPECT_EQ(given.attitude_deg, PriorError{}.attitude_deg);
  const PriorError plain = read_prior(TomlTable::read_text("", "prior.toml"));
  EXPECT_EQ(plain.range_fraction, 0.01);
}

TEST(Prior, MistakesGetOneClearLine) {
  EXPECT_THAT(error_of([] { read_prior(TomlTable::read_text("range_percent = 50", "p.toml")); }),
              testing::HasSubstr("range_percent is 50, must be a number, from 0 to 20"));
}

}  // namespace
}  // namespace sightline
