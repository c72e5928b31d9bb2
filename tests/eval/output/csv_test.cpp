// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/csv.h"

#include <utility>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/output/csv_reader.h"
#include "eval/output/json.h"
#include "scenes/files/pauses.h"
#include "tests/scenes/error_text.h"
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

// As editors on Windows save "Unicode": the text of an error would end at the first byte of 0.
TEST(CsvReader, TakesNumbersAndLinesAsOthersWriteThem) {
  const TemporaryFolder folder;
  for (const char* end : {"\n", "\r\n", "\r"}) {
    const auto text = fmt::format("a,b{0}+3,03{0}3.0,-3e0{0}", end);
    CsvReader csv(folder.write("t.csv", text));
    for (const int b : {3, -3}) {
      ASSERT_TRUE(csv.next());
      EXPECT_EQ(csv.integer("a"), 3);
      EXPECT_EQ(csv.integer("b"), b);
    }
    EXPECT_EQ(csv.line(), 3);
    EXPECT_FALSE(csv.next());
  }
  for (const char* bad : {"3.5", "3000000000", "nan", "inf", "three", "3 4", "++3"}) {
    CsvReader csv(folder.write("t.csv", fmt::format("a\n{}\n", bad)));
    ASSERT_TRUE(csv.next());
    EXPECT_THAT(error_of([&] { csv.integer("a"); }), testing::HasSubstr("must be a whole number"))
        << bad;
  }
}

TEST(CsvReader, RefusesWhatIsNoText) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& text) {
    return error_of([&] { CsvReader(folder.write("a.csv", text)); });
  };
  EXPECT_EQ(error("a,b\n"), "");
  EXPECT_THAT(
      error(std::string("\xFF\xFE"
                        "a\0,\0b\0",
                        8)),
      testing::HasSubstr("a.csv: line 1 has a byte of value 0, which no text has: it may be"));
}

class HeardASignal {};

// While it lives what is read is interrupted at once.
class Signal {
 public:
  Signal() {
    call_in_pauses([] { throw HeardASignal(); });
  }
  ~Signal() { call_in_pauses(nullptr); }
};

TEST(Pauses, EndTheReadingOfTablesAndJsonThatAreLong) {
  const TemporaryFolder folder;
  std::string rows = "a,b\n", list = "[0";
  for (int i = 0; i < 1000; ++i) {
    rows += "1,2\n";
    list += ",1";
  }
  const auto table = folder.write("a.csv", rows);
  const auto json = folder.write("a.json", list + "]");
  const auto read_table = [&] {
    CsvReader csv(table);
    while (csv.next()) continue;
    return csv.line();
  };
  EXPECT_EQ(read_table(), 1001);
  EXPECT_EQ(read_json(json).size(), 1001u);
  const Signal signal;
  EXPECT_THROW(read_table(), HeardASignal);
  EXPECT_THROW(read_json(json), HeardASignal);
}

}  // namespace
}  // namespace sightline
