// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/csv.h"

#include <utility>

#include <gtest/gtest.h>

#include "eval/output/csv_reader.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

TEST(CsvLine, QuotesOnlyWhatWouldBeTornApart) {
  CsvLine line;
  line << "plain text"
       << "a,b"
       << "say \"no\""
       << "two\nlines"
       << "";
  EXPECT_EQ(std::move(line).end(), "plain text,\"a,b\",\"say \"\"no\"\"\",\"two\nlines\",\n");
}

TEST(CsvLine, WritesNoFormula) {
  CsvLine line;
  line << "=cmd|' /C calc'!A0"
       << "@SUM(1)"
       << "-a"
       << "-5 deg"
       << "-1e-3"
       << "+inf"
       << "a=b";
  EXPECT_EQ(std::move(line).end(), "'=cmd|' /C calc'!A0,'@SUM(1),'-a,-5 deg,-1e-3,+inf,a=b\n");
}

TEST(CsvLine, IsReadBackAsItWasWritten) {
  const TemporaryFolder folder;
  CsvLine line;
  line << "=1+1"
       << "'quoted'"
       << "-a";
  CsvReader csv(folder.write("a.csv", "a,b,c\n" + std::move(line).end()));
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.text("a"), "=1+1");
  EXPECT_EQ(csv.text("b"), "'quoted'");
  EXPECT_EQ(csv.text("c"), "-a");
}

TEST(CsvLine, WritesTheShortestNumbersThatReadBackTheSame) {
  CsvLine line;
  line << 0.1 << 1.0 / 3 << -2 << int64_t{9'007'199'254'740'993};
  EXPECT_EQ(std::move(line).end(), "0.1,0.3333333333333333,-2,9007199254740993\n");
}

TEST(CsvLine, EmptyFieldsKeepTheirPlaces) {
  CsvLine line;
  line << "";
  line.empty_fields(2) << 1;
  EXPECT_EQ(std::move(line).end(), ",,,1\n");
}

}  // namespace
}  // namespace sightline
