// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/removal_limits.h"

#include <vector>

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(RemovalLimit, LeavesFourPoints) {
  EXPECT_EQ(removal_limit({}, 3), 0u);
  EXPECT_EQ(removal_limit({}, 4), 0u);
  EXPECT_EQ(removal_limit({}, 5), 1u);
  EXPECT_EQ(removal_limit({}, 8), 4u);
  OutlierOptions options;
  options.max_removed = 2;
  EXPECT_EQ(removal_limit(options, 8), 2u);
  EXPECT_EQ(removal_limit(options, 5), 1u);
  options.max_removed = -1;
  EXPECT_EQ(removal_limit(options, 8), 0u);
}

TEST(MinorityLimit, LeavesAMajorityAndTwoRedundantCoordinates) {
  const OutlierOptions unsaid;
  const std::vector<std::size_t> expected = {0, 0, 0, 0, 0, 1, 2, 3, 3, 4, 4, 5, 5};
  for (std::size_t n = 0; n < expected.size(); ++n)
    EXPECT_EQ(minority_limit(unsaid, n), expected[n]);

  OutlierOptions said;
  said.max_removed = 6;
  EXPECT_EQ(minority_limit(said, 12), 6u);
  EXPECT_EQ(minority_limit(said, 8), 4u);
  EXPECT_EQ(minority_limit(said, 3), 0u);
  said.max_removed = 0;
  EXPECT_EQ(minority_limit(said, 8), 0u);
  said.max_removed = -1;
  EXPECT_EQ(minority_limit(said, 8), 0u);
}

}  // namespace
}  // namespace sightline
