// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The tables of a store: their description, older schemas, and files that have other tables.
#include <cmath>
#include <fstream>
#include <iterator>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/results/columns_page.h"
#include "eval/results/store.h"
#include "tests/eval/results/stored_trials.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;

using StoreSchemaTest = StoreTest;

std::string text_of(const std::filesystem::path& path) {
  std::ifstream stream(path);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

// Other programs read the file by its description.
TEST_F(StoreSchemaTest, IsDescribedWithEveryTableAndColumn) {
  Store::create(file(), {});
  const std::string page = columns_page();
  SQLite::Database database(file().string());
  const std::filesystem::path docs = std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "docs";
  EXPECT_THAT(
      text_of(docs / "store.md"),
      HasSubstr(fmt::format("version {}", database.execAndGet("PRAGMA user_version").getInt())));
  SQLite::Statement columns(database,
                            "SELECT m.name, p.name FROM sqlite_master m, pragma_table_info(m.name) "
                            "p WHERE m.type = 'table' AND m.name != 'meta'");
  int count = 0;
  for (; columns.executeStep(); ++count) {
    const std::string table = columns.getColumn(0).getString();
    const std::string column = columns.getColumn(1).getString();
    const size_t section = page.find("## results.sqlite: " + table);
    ASSERT_NE(section, std::string::npos) << table;
    const std::string body = page.substr(section, page.find("\n## ", section) - section);
    EXPECT_THAT(body, HasSubstr("`" + column + "`")) << table;
  }
  EXPECT_GT(count, 70);
}

TEST_F(StoreSchemaTest, HasAPageOfTheDocsThatSaysWhatTheProgramPrints) {
  const std::string page =
      text_of(std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "docs" / "columns.md");
  const size_t begin = page.find("# The columns");
  ASSERT_NE(begin, std::string::npos);
  EXPECT_EQ(page.substr(begin), columns_page())
      << "after its licence, docs/columns.md is what `sightline list columns` prints";
}

TEST_F(StoreSchemaTest, IsNotOpenedFromAnotherVersion) {
  Store::create(file(), {});
  SQLite::Database(file().string(), SQLite::OPEN_READWRITE).exec("PRAGMA user_version = 1");
  expect_complaint(error_of([&] { Store::open(file()); }), file(),
                   "results of version 1; this program reads versions 4 to 5");
}

// What the schema of version 4 had, which knew nothing of what solvers say of themselves, nor of
// lines.
void make_older(const std::filesystem::path& file) {
  SQLite::Database database(file.string(), SQLite::OPEN_READWRITE);
  for (const char* column : {"ambiguous", "removed_probability", "removal_limit_reached",
                             "test_failed", "removed_lines"}) {
    database.exec(fmt::format("ALTER TABLE estimates DROP COLUMN {}", column));
  }
  database.exec("DROP TABLE lines");
  database.exec("PRAGMA user_version = 4");
}

// What is left of a trial in such a store.
TrialRecord as_in_version_4(TrialRecord trial) {
  for (EstimateRecord& estimate : trial.pose_trial().estimates) {
    estimate.is_ambiguous.reset();
    estimate.removed_probability.reset();
    estimate.is_removal_limit_reached.reset();
    estimate.is_test_failed.reset();
    estimate.removed_lines.clear();
  }
  trial.pose_trial().lines.clear();
  return trial;
}

TEST_F(StoreSchemaTest, OfAnOlderSchemaIsReadAndAddedTo) {
  Store::create(file(), {}).add(std::vector{drawn_trial(0)});
  make_older(file());
  expect_same(Store::open(file()).trials(), {as_in_version_4(drawn_trial(0))});

  Store joined = Store::create(file("joined"), {});
  joined.add_all_of(file());
  expect_same(joined.trials(), {as_in_version_4(drawn_trial(0))});

  Store::open(file()).add(std::vector{drawn_trial(1)});
  expect_same(Store::open(file()).trials(), {as_in_version_4(drawn_trial(0)), drawn_trial(1)});
}

TEST_F(StoreSchemaTest, WithoutAColumnOfNumbersReadsThemAsNone) {
  Store::create(file(), {}).add(std::vector{drawn_trial(0)});
  SQLite::Database(file().string(), SQLite::OPEN_READWRITE)
      .exec("ALTER TABLE estimates DROP COLUMN add_m");
  const TrialRecord trial = Store::open(file()).trials().front();
  EXPECT_TRUE(std::isnan(trial.estimates()[0].add_m));
  EXPECT_EQ(trial.estimates()[0].mssd_m, drawn_trial(0).estimates()[0].mssd_m);
}

TEST_F(StoreSchemaTest, IsNotOpenedWithAWrongTable) {
  const auto complaint_after = [&](const char* sql) {
    std::filesystem::remove(file());
    Store::create(file(), {});
    SQLite::Database(file().string(), SQLite::OPEN_READWRITE).exec(sql);
    return error_of([&] { Store::open(file()); });
  };
  expect_complaint(complaint_after("DROP TABLE estimates"), file(), "no table estimates");
  expect_complaint(complaint_after("ALTER TABLE estimates DROP COLUMN solver"), file(),
                   "table estimates without solver");
  expect_complaint(
      complaint_after("DROP TABLE orientations; CREATE TABLE orientations (trial, method, status)"),
      file(), "table orientations without position");
}

// What is read from a view is computed by whoever made the file, and a trigger changes what is
// added.
TEST_F(StoreSchemaTest, IsNotOpenedWithAnythingButTables) {
  const auto complaint_after = [&](const char* sql) {
    std::filesystem::remove(file());
    Store::create(file(), {}).add(std::vector{drawn_trial(0)});
    SQLite::Database(file().string(), SQLite::OPEN_READWRITE).exec(sql);
    return error_of([&] { Store::open(file()); });
  };
  expect_complaint(complaint_after("ALTER TABLE estimates RENAME TO e; "
                                   "CREATE VIEW estimates AS SELECT * FROM e"),
                   file(), "estimates is a view; must have tables alone");
  expect_complaint(complaint_after("CREATE TRIGGER t AFTER INSERT ON trials BEGIN "
                                   "DELETE FROM estimates; END"),
                   file(), "t is a trigger");
  EXPECT_EQ(complaint_after("CREATE INDEX i ON estimates (solver)"), "");
}

// SQLite keeps any value in any column, and reads a text as the number 0.
TEST_F(StoreSchemaTest, SaysSoWhenAValueIsOfAnotherKindOrARowBelongsNowhere) {
  const auto complaint_after = [&](const char* sql) {
    std::filesystem::remove(file());
    Store::create(file(), {}).add(std::vector{drawn_trial(0), drawn_trial(4)});
    SQLite::Database(file().string(), SQLite::OPEN_READWRITE).exec(sql);
    return error_of([&] { (void)Store::open(file()).trials(); });
  };
  EXPECT_EQ(complaint_after("UPDATE estimates SET geodesic_deg = 1"), "");
  expect_complaint(complaint_after("UPDATE estimates SET geodesic_deg = 'small'"), file(),
                   "geodesic_deg is no number");
  expect_complaint(complaint_after("UPDATE estimates SET false_removals = 1.5"), file(),
                   "false_removals is no whole number");
  expect_complaint(complaint_after("UPDATE trials SET condition = 5000000000"), file(),
                   "condition is no whole number below 2^31");
  expect_complaint(complaint_after("UPDATE observations SET is_outlier = 2"), file(),
                   "is_outlier is no 0 or 1");
  expect_complaint(complaint_after("DELETE FROM estimates WHERE trial = 0 AND position = 0"),
                   file(), "lacks position 0 of trial 0");
  for (const char* sql : {"UPDATE estimates SET trial = 2 WHERE trial = 4",
                          "UPDATE observations SET trial = 7 WHERE trial = 4"}) {
    EXPECT_THAT(complaint_after(sql), HasSubstr("which table trials has not")) << sql;
  }
}

TEST_F(StoreSchemaTest, SaysSoWhenAStatusOrALabelIsUnknown) {
  for (const char* sql :
       {"UPDATE estimates SET status = 'fine'", "UPDATE observations SET status = 'fine'",
        "UPDATE observations SET label = 'fine'"}) {
    std::filesystem::remove(file());
    Store::create(file(), {}).add(std::vector{drawn_trial(0)});
    SQLite::Database(file().string(), SQLite::OPEN_READWRITE).exec(sql);
    expect_complaint(error_of([&] { (void)Store::open(file()).trials(); }), file(),
                     "'fine' is none of");
  }
}

}  // namespace
}  // namespace sightline
