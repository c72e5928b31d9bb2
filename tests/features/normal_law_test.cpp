// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/normal_law.h"

#include <cmath>
#include <numbers>

#include <boost/math/special_functions/owens_t.hpp>
#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(NormalLaw, IsThatOfTheStandardLibrary) {
  for (double z = -8; z <= 8; z += 0.0137) {
    const NormalLaw::Value value = normal_law().at(z);
    EXPECT_NEAR(value.cumulative, 0.5 * std::erfc(-z / std::numbers::sqrt2), 2e-5) << z;
    EXPECT_NEAR(value.density, std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi), 2e-5) << z;
  }
}

TEST(OwensT, IsThatOfBoost) {
  for (double d = 0.003; d < 6; d += 0.0173) {
    for (double t = -7; t < 7; t += 0.0371) {
      ASSERT_NEAR(owens_t(d, t), boost::math::owens_t(d, t / d), 1e-4) << d << ' ' << t;
    }
  }
}

// On the line itself it is the angle alone.
TEST(OwensT, OnTheLineIsAQuarter) {
  EXPECT_NEAR(owens_t(0, 1), 0.25, 1e-6);
  EXPECT_NEAR(owens_t(0, -1), -0.25, 1e-6);
  EXPECT_NEAR(owens_t(0, 9), 0.25, 1e-6);
  EXPECT_EQ(owens_t(0, 0), 0);
}

}  // namespace
}  // namespace sightline
