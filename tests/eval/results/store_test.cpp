// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/store.h"

#include <cstdint>
#include <fstream>
#include <limits>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/eval/results/stored_trials.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST_F(StoreTest, GivesBackWhatWasAddedBitByBit) {
  std::vector<TrialRecord> trials;
  for (int i = 0; i < 20; ++i) {
    trials.push_back(i % 3 == 0 ? drawn_orientation_trial(i) : drawn_trial(i));
  }
  Store::create(file(), {}).add(trials);
  expect_same(Store::open(file()).trials(), trials);
}

TEST_F(StoreTest, KeepsNumbersThatAreNotOrdinary) {
  TrialRecord trial = drawn_trial(0);
  trial.true_cam_from_target.rotation(0, 1) = -0.0;
  trial.true_cam_from_target.rotation(1, 1) = 1;  // whole, and still a double
  trial.true_cam_from_target.translation.z() = std::numeric_limits<double>::denorm_min();
  trial.pose_trial().observations[0].error_px = std::numeric_limits<double>::max();
  trial.pose_trial().estimates[0].geodesic_deg = kInfinity;
  trial.pose_trial().estimates[0].add_m = -kInfinity;
  trial.pose_trial().estimates[1].reprojection_rms_px = kNaN;
  trial.pose_trial().estimates[1].cam_from_target.rotation.setConstant(kNaN);
  Store store = Store::create(file(), {});
  store.add(std::vector{trial});
  expect_same(store.trials(), {trial});
}

TEST_F(StoreTest, KeepsTrialsWithoutObservationsBetweenOthers) {
  std::vector<TrialRecord> trials{drawn_trial(0), drawn_trial(1), drawn_trial(2), drawn_trial(3)};
  trials[1].pose_trial().observations.clear();
  trials[2].pose_trial().estimates.clear();
  trials[3].pose_trial().estimates[0].removed.clear();
  trials[3].pose_trial().estimates[1].covariance.reset();
  Store store = Store::create(file(), {});
  store.add(trials);
  expect_same(store.trials(), trials);
}

TEST_F(StoreTest, OrdersTrialsByNumberHoweverTheyCame) {
  Store store = Store::create(file(), {});
  store.add(std::vector{drawn_trial(5), drawn_trial(1)});
  store.add(std::vector{drawn_trial(int64_t{1} << 40), drawn_trial(3)});
  expect_same(store.trials(),
              {drawn_trial(1), drawn_trial(3), drawn_trial(5), drawn_trial(int64_t{1} << 40)});
}

TEST_F(StoreTest, IsEmptyAtFirstAndAfterAddingNothing) {
  Store store = Store::create(file(), {});
  store.add({});
  EXPECT_TRUE(store.trials().empty());
}

TEST_F(StoreTest, KnowsWhatItHolds) {
  Store store = Store::create(file(), {});
  EXPECT_FALSE(store.first_trial());
  store.add(std::vector{drawn_trial(4), drawn_trial(2)});
  EXPECT_EQ(store.size(), 2);
  EXPECT_EQ(store.first_trial(), 2);
  EXPECT_TRUE(store.holds(4));
  EXPECT_FALSE(store.holds(3));
  EXPECT_EQ(store.held(4), (std::vector{false, false, true, false}));
}

TEST_F(StoreTest, KeepsItsMeta) {
  const std::map<std::string, std::string> meta{{"study", "boeing-table1"}, {"toml", "a\nb = '°'"}};
  Store::create(file(), meta);
  EXPECT_EQ(Store::open(file()).meta(), meta);
}

TEST_F(StoreTest, CanBeAddedToLater) {
  Store::create(file(), {}).add(std::vector{drawn_trial(0)});
  Store::open(file()).add(std::vector{drawn_trial(1)});
  expect_same(Store::open(file()).trials(), {drawn_trial(0), drawn_trial(1)});
}

TEST_F(StoreTest, RollsBackWhatAKilledWriterLeft) {
  Store::create(file(), {}).add(std::vector{drawn_trial(0)});
  const auto size_before = std::filesystem::file_size(file());
  // A transaction too large for its cache lies half in the file, and the way back in the journal.
  SQLite::Database writer(file().string(), SQLite::OPEN_READWRITE);
  writer.exec("PRAGMA cache_size = 1; BEGIN");
  for (int trial = 1; trial < 500; ++trial) {
    writer.exec(
        fmt::format("INSERT INTO trials (trial, condition, redraws, true_tx_m) "
                    "VALUES ({}, 0, 0, randomblob(1000))",
                    trial));
  }
  std::filesystem::copy_file(file(), file("killed"));
  std::filesystem::copy_file(file("results.sqlite-journal"), file("killed-journal"));
  ASSERT_GT(std::filesystem::file_size(file("killed")), size_before) << "nothing to roll back";
  expect_same(Store::open(file("killed")).trials(), {drawn_trial(0)});
  EXPECT_EQ(std::filesystem::file_size(file("killed")), size_before);
}

// Of several databases, whose rolling back removes a file.
std::string journal_that_removes(const std::filesystem::path& file) {
  const std::string magic = "\xd9\xd5\x05\xf9\x20\xa1\x63\xd7", name = file.string();
  const auto big_endian = [](uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
    return bytes;
  };
  uint32_t sum = 0;
  for (const char letter : name) sum += static_cast<uint32_t>(letter);
  return magic + std::string(504, '\0') + big_endian(0) + name +
         big_endian(static_cast<uint32_t>(name.size())) + big_endian(sum) + magic;
}

// A journal that ends with the name of a file has SQLite remove that file, whatever it is.
TEST_F(StoreTest, IsNotOpenedBesideAJournalThatNamesAFile) {
  namespace fs = std::filesystem;
  Store::create(file(), {}).add(std::vector{drawn_trial(0)});
  const fs::path precious = file("precious"), journal = file("results.sqlite-journal");
  std::ofstream(precious) << "years of work";
  SQLite::Database writer(file().string(), SQLite::OPEN_READWRITE);
  writer.exec("BEGIN; UPDATE trials SET true_tx_m = 1");
  fs::copy_file(file(), file("copy"));
  fs::copy_file(journal, file("copy-journal"));
  writer.exec("ROLLBACK");
  expect_same(Store::open(file("copy")).trials(), {drawn_trial(0)});

  const std::string crafted = journal_that_removes(precious);
  std::ofstream(journal, std::ios::binary) << crafted;
  expect_complaint(error_of([&] { Store::open(file()); }), journal, "is of several databases");
  // Beside a new store there is none, in whatever folder it is made.
  for (const char* left : {"new-journal", "new.partial-journal"}) {
    std::ofstream(file(left), std::ios::binary) << crafted;
  }
  Store::create(file("new"), {}).add(std::vector{drawn_trial(0)});
  expect_same(Store::open(file("new")).trials(), {drawn_trial(0)});
  EXPECT_TRUE(fs::exists(precious));

  // Nor is a pipe waited for, or what a link leads to looked at.
  for (const char* ending : {"-journal", "-wal", "-shm"}) {
    const fs::path beside = file(("results.sqlite" + std::string(ending)).c_str());
    fs::remove(journal);
    ASSERT_EQ(mkfifo(beside.c_str(), 0600), 0);
    expect_complaint(error_of([&] { Store::open(file()); }), beside, "must be a file");
    fs::remove(beside);
    fs::create_symlink(precious, beside);
    expect_complaint(error_of([&] { Store::open(file()); }), beside, "must be a file");
    fs::remove(beside);
  }
  expect_same(Store::open(file()).trials(), {drawn_trial(0)});
}

TEST_F(StoreTest, IsReadButNotWrittenThroughALink) {
  Store::create(file("there"), {}).add(std::vector{drawn_trial(0)});
  std::filesystem::create_symlink(file("there"), file());
  Store store = Store::open(file());
  expect_same(store.trials(), {drawn_trial(0)});
  expect_complaint(error_of([&] { store.add(std::vector{drawn_trial(1)}); }), file(),
                   "is a link, which nothing is written through");
  Store::create(file("other"), {}).add(std::vector{drawn_trial(1)});
  expect_complaint(error_of([&] { store.add_all_of(file("other")); }), file(),
                   "is a link, which nothing is written through");
  EXPECT_EQ(Store::open(file("there")).size(), 1);
}

// With a log beside it, SQLite would write to it by its mode alone.
TEST_F(StoreTest, LeavesSomeoneElsesDatabaseAsItIs) {
  const std::filesystem::path precious = file("precious.db");
  SQLite::Database writer(precious.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  writer.exec("PRAGMA journal_mode = WAL; CREATE TABLE t (x); INSERT INTO t VALUES (1)");
  const std::filesystem::path copy = file("copy.db"), log = file("copy.db-wal");
  std::filesystem::copy_file(precious, copy);
  std::filesystem::copy_file(file("precious.db-wal"), log);
  const std::string before = bytes_of(copy), log_before = bytes_of(log);
  std::filesystem::create_symlink(copy, file());
  expect_complaint(error_of([&] { Store::open(file()); }), file(), "not one of sightline's");
  EXPECT_EQ(bytes_of(copy), before);
  EXPECT_EQ(bytes_of(log), log_before);
  EXPECT_FALSE(log_before.empty());
}

TEST_F(StoreTest, LeavesNoOtherFileBehind) {
  Store::create(file(), {}).add(std::vector{drawn_trial(0)});
  const std::filesystem::directory_iterator files(file().parent_path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST_F(StoreTest, RefusesATrialThatItHoldsAndAddsNoneOfItsBatch) {
  Store store = Store::create(file(), {});
  store.add(std::vector{drawn_trial(7)});
  const std::vector<TrialRecord> batch{drawn_trial(6), drawn_trial(7)};
  expect_complaint(error_of([&] { store.add(batch); }), file(), "holds trial 7 already");
  expect_same(store.trials(), {drawn_trial(7)});
}

TEST_F(StoreTest, TakesOverAllTrialsOfOthers) {
  Store::create(file("even"), {}).add(std::vector{drawn_trial(0), drawn_trial(2)});
  Store::create(file("odd"), {}).add(std::vector{drawn_trial(1), drawn_trial(3)});
  Store store = Store::create(file(), {{"key", "kept"}});
  store.add_all_of(file("even"));
  store.add_all_of(file("odd"));
  expect_same(store.trials(), {drawn_trial(0), drawn_trial(1), drawn_trial(2), drawn_trial(3)});
  EXPECT_EQ(store.meta(), (std::map<std::string, std::string>{{"key", "kept"}}));
}

TEST_F(StoreTest, TakesOverNoneOfAStoreThatHoldsATrialTwice) {
  Store::create(file("other"), {}).add(std::vector{drawn_trial(6), drawn_trial(7)});
  Store store = Store::create(file(), {});
  store.add(std::vector{drawn_trial(7)});
  expect_complaint(error_of([&] { store.add_all_of(file("other")); }), file(), "UNIQUE");
  expect_complaint(error_of([&] { store.add_all_of(file("nowhere")); }), file("nowhere"),
                   "no such file");
  expect_same(store.trials(), {drawn_trial(7)});
  store.add(std::vector{drawn_trial(6)});  // it is as good as before
  EXPECT_EQ(store.trials().size(), 2u);
}

TEST_F(StoreTest, IsNotMadeOverAFile) {
  std::ofstream(file()) << "precious";
  expect_complaint(error_of([&] { Store::create(file(), {}); }), file(), "exists already");
  std::string content;
  std::getline(std::ifstream(file()), content);
  EXPECT_EQ(content, "precious");
}

TEST_F(StoreTest, IsNotMadeInAFolderThatIsNotThere) {
  const auto nowhere = file("nowhere") / "results.sqlite";
  expect_complaint(error_of([&] { Store::create(nowhere, {}); }), nowhere, "cannot be created");
}

TEST_F(StoreTest, IsNotMadeUnderAFile) {
  std::ofstream(file("plain")) << "a file";
  const auto under = file("plain") / "results.sqlite";
  expect_complaint(error_of([&] { Store::create(under, {}); }), under, "cannot be created");
}

TEST_F(StoreTest, IsNotMadeInAWriteProtectedFolder) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  std::filesystem::permissions(file().parent_path(), std::filesystem::perms::owner_read |
                                                         std::filesystem::perms::owner_exec);
  expect_complaint(error_of([&] { Store::create(file(), {}); }), file(), "cannot be created");
  std::filesystem::permissions(file().parent_path(), std::filesystem::perms::owner_all);
}

TEST_F(StoreTest, IsNotOpenedWhereThereIsNone) {
  expect_complaint(error_of([&] { Store::open(file()); }), file(), "no such file");
  EXPECT_FALSE(std::filesystem::exists(file()));
  const auto folder = file().parent_path();
  expect_complaint(error_of([&] { Store::open(folder); }), folder, "not a file");
}

TEST_F(StoreTest, IsNotOpenedFromGarbage) {
  std::ofstream(file()) << std::string(5000, 'x');
  expect_complaint(error_of([&] { Store::open(file()); }), file(), "not an SQLite file");
}

TEST_F(StoreTest, IsNotOpenedFromAnEmptyFileOrSomeoneElsesDatabase) {
  std::ofstream(file()).flush();
  expect_complaint(error_of([&] { Store::open(file()); }), file(), "not one of sightline's");
  SQLite::Database(file("other").string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
      .exec("CREATE TABLE meta (key, value); PRAGMA user_version = 1");
  expect_complaint(error_of([&] { Store::open(file("other")); }), file("other"),
                   "not one of sightline's");
}

TEST_F(StoreTest, SaysSoWhenTheFileIsCutShort) {
  std::vector<TrialRecord> trials;
  for (int i = 0; i < 100; ++i) trials.push_back(drawn_trial(i));
  Store::create(file(), {}).add(trials);
  std::filesystem::resize_file(file(), std::filesystem::file_size(file()) / 2);
  const std::string text = error_of([&] { (void)Store::open(file()).trials(); });
  expect_complaint(text, file(), "cannot be read");
}

TEST_F(StoreTest, SaysSoWhenAListIsNoList) {
  Store::create(file(), {}).add(std::vector{drawn_trial(0)});
  SQLite::Database(file().string(), SQLite::OPEN_READWRITE)
      .exec("UPDATE estimates SET removed = 'nose'");
  const std::string text = error_of([&] { (void)Store::open(file()).trials(); });
  expect_complaint(text, file(), "cannot be read");
}

}  // namespace
}  // namespace sightline
