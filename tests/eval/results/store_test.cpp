// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/store.h"

#include <bit>
#include <cmath>
#include <fstream>
#include <limits>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "scenes/random/random.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class StoreTest : public ::testing::Test {
 protected:
  StoreTest() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              fmt::format("sightline_store_{}_{}", test->name(), getpid());
    std::filesystem::create_directories(folder_);
  }
  ~StoreTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path file(const char* name = "results.sqlite") const { return folder_ / name; }

 private:
  std::filesystem::path folder_;
};

void expect_complaint(const std::string& text, const std::filesystem::path& file,
                      const char* reason) {
  EXPECT_THAT(text, HasSubstr(file.string()));
  EXPECT_THAT(text, HasSubstr(reason));
  EXPECT_THAT(text, Not(HasSubstr("\n")));
}

// Every number of a record as bits, so that -0 differs from 0 and NaN equals NaN.
std::vector<uint64_t> bits_of(const Pose& pose) {
  std::vector<uint64_t> bits;
  for (const double x : pose.rotation.reshaped()) bits.push_back(std::bit_cast<uint64_t>(x));
  for (const double x : pose.translation) bits.push_back(std::bit_cast<uint64_t>(x));
  return bits;
}

void expect_same_bits(double a, double b) {
  EXPECT_EQ(std::bit_cast<uint64_t>(a), std::bit_cast<uint64_t>(b)) << a << " and " << b;
}

void expect_same(const ObservationRecord& a, const ObservationRecord& b) {
  EXPECT_EQ(a.feature, b.feature);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.is_visible, b.is_visible);
  EXPECT_EQ(a.is_outlier, b.is_outlier);
  expect_same_bits(a.pixel.x(), b.pixel.x());
  expect_same_bits(a.pixel.y(), b.pixel.y());
  expect_same_bits(a.true_pixel.x(), b.true_pixel.x());
  expect_same_bits(a.true_pixel.y(), b.true_pixel.y());
  expect_same_bits(a.error_px, b.error_px);
  expect_same_bits(a.error_sigmas, b.error_sigmas);
  EXPECT_EQ(a.label, b.label);
}

void expect_same(const EstimateRecord& a, const EstimateRecord& b) {
  EXPECT_EQ(a.solver, b.solver);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(bits_of(a.cam_from_target), bits_of(b.cam_from_target));
  expect_same_bits(a.theta_error_deg, b.theta_error_deg);
  expect_same_bits(a.t_error_percent, b.t_error_percent);
  expect_same_bits(a.geodesic_deg, b.geodesic_deg);
  expect_same_bits(a.reprojection_rms_px, b.reprojection_rms_px);
  expect_same_bits(a.add_m, b.add_m);
  expect_same_bits(a.mssd_m, b.mssd_m);
  expect_same_bits(a.mspd_px, b.mspd_px);
  EXPECT_EQ(a.removed, b.removed);
  EXPECT_EQ(a.false_removals, b.false_removals);
  EXPECT_EQ(a.missed_outliers, b.missed_outliers);
  expect_same_bits(a.nees, b.nees);
  ASSERT_EQ(a.covariance.has_value(), b.covariance.has_value());
  if (!a.covariance) return;
  for (int i = 0; i < 36; ++i) {
    expect_same_bits(a.covariance->reshaped()(i), b.covariance->reshaped()(i));
  }
}

void expect_same(const OrientationRecord& a, const OrientationRecord& b) {
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.failures, b.failures);
  expect_same_bits(a.angle_error_deg, b.angle_error_deg);
  expect_same_bits(a.theta_error_deg, b.theta_error_deg);
  expect_same_bits(a.t_error_percent, b.t_error_percent);
  expect_same_bits(a.geodesic_deg, b.geodesic_deg);
  expect_same_bits(a.time_ns, b.time_ns);
}

void expect_same(const TrialRecord& a, const TrialRecord& b);

template <typename Record>
void expect_same(const std::vector<Record>& a, const std::vector<Record>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) expect_same(a[i], b[i]);
}

void expect_same(const TrialRecord& a, const TrialRecord& b) {
  SCOPED_TRACE(fmt::format("trial {}", a.trial));
  EXPECT_EQ(a.trial, b.trial);
  EXPECT_EQ(a.condition, b.condition);
  EXPECT_EQ(a.redraws, b.redraws);
  EXPECT_EQ(bits_of(a.true_cam_from_target), bits_of(b.true_cam_from_target));
  EXPECT_EQ(bits_of(a.prior_cam_from_target), bits_of(b.prior_cam_from_target));
  expect_same(a.observations, b.observations);
  expect_same(a.estimates, b.estimates);
  expect_same(a.orientations, b.orientations);
}

Pose drawn_pose(RandomStream& random) {
  return {random.rotation(), 1000 * random.normal3()};
}

Eigen::Matrix<double, 6, 6> drawn_covariance(RandomStream& random) {
  Eigen::Matrix<double, 6, 6> root;
  for (double& number : root.reshaped()) number = random.normal();
  const Eigen::Matrix<double, 6, 6> square = root * root.transpose();
  return square.selfadjointView<Eigen::Upper>();
}

// A trial with a different number in every place.
TrialRecord drawn_trial(int64_t number) {
  RandomStream random(3, "trial", number);
  TrialRecord trial;
  trial.trial = number;
  trial.condition = static_cast<int>(number % 4);
  trial.redraws = static_cast<int>(number % 7);
  trial.true_cam_from_target = drawn_pose(random);
  trial.prior_cam_from_target = drawn_pose(random);
  for (const char* feature : {"nose", "wing_tip_le_port", "an 'odd', \"name\" °"}) {
    const Eigen::Vector2d pixel(random.normal(), random.normal());
    const Eigen::Vector2d true_pixel(random.normal(), random.normal());
    trial.observations.push_back({feature, "found", random.uniform() < 0.5, pixel, true_pixel,
                                  random.normal(), random.normal(), random.uniform() < 0.5,
                                  "wrong line"});
  }
  for (const char* solver : {"orpe", "lspe"}) {
    const Pose pose = drawn_pose(random);
    const std::array<double, 7> e{random.normal(), random.normal(), random.normal(),
                                  random.normal(), random.normal(), random.normal(),
                                  random.normal()};
    trial.estimates.push_back({solver,
                               "ok",
                               pose,
                               e[0],
                               e[1],
                               e[2],
                               e[3],
                               e[4],
                               e[5],
                               e[6],
                               {"nose", "an 'odd', \"name\" °"},
                               1,
                               2,
                               drawn_covariance(random),
                               random.normal()});
  }
  for (const char* method : {"fast", "umeyama"}) {
    trial.orientations.push_back({method, "degenerate", 3, random.normal(), random.normal(),
                                  random.normal(), random.normal(), random.normal()});
  }
  trial.orientations.push_back({.method = "not timed"});
  return trial;
}

TEST_F(StoreTest, GivesBackWhatWasAddedBitByBit) {
  std::vector<TrialRecord> trials;
  for (int i = 0; i < 20; ++i) trials.push_back(drawn_trial(i));
  Store::create(file(), {}).add(trials);
  expect_same(Store::open(file()).trials(), trials);
}

TEST_F(StoreTest, KeepsNumbersThatAreNotOrdinary) {
  TrialRecord trial = drawn_trial(0);
  trial.true_cam_from_target.rotation(0, 1) = -0.0;
  trial.true_cam_from_target.rotation(1, 1) = 1;  // whole, and still a double
  trial.true_cam_from_target.translation.z() = std::numeric_limits<double>::denorm_min();
  trial.observations[0].error_px = std::numeric_limits<double>::max();
  trial.estimates[0].geodesic_deg = kInfinity;
  trial.estimates[0].add_m = -kInfinity;
  trial.estimates[1].reprojection_rms_px = kNaN;
  trial.estimates[1].cam_from_target.rotation.setConstant(kNaN);
  Store store = Store::create(file(), {});
  store.add(std::vector{trial});
  expect_same(store.trials(), {trial});
}

TEST_F(StoreTest, KeepsTrialsWithoutObservationsBetweenOthers) {
  std::vector<TrialRecord> trials{drawn_trial(0), drawn_trial(1), drawn_trial(2), drawn_trial(3)};
  trials[1].observations.clear();
  trials[2].estimates.clear();
  trials[3].estimates[0].removed.clear();
  trials[3].estimates[1].covariance.reset();
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

// Other programs read the file by its description.
TEST_F(StoreTest, IsDescribedWithEveryTableAndColumn) {
  Store::create(file(), {});
  const std::string text = [] {
    std::ifstream stream(std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "docs" / "store.md");
    return std::string(std::istreambuf_iterator<char>(stream), {});
  }();
  SQLite::Database database(file().string());
  EXPECT_THAT(text, HasSubstr(fmt::format("version {}",
                                          database.execAndGet("PRAGMA user_version").getInt())));
  SQLite::Statement columns(database,
                            "SELECT m.name, p.name FROM sqlite_master m, pragma_table_info(m.name) "
                            "p WHERE m.type = 'table'");
  int count = 0;
  for (; columns.executeStep(); ++count) {
    const std::string table = columns.getColumn(0).getString();
    const std::string column = columns.getColumn(1).getString();
    const size_t section = text.find("## " + table);
    ASSERT_NE(section, std::string::npos) << table;
    const std::string body = text.substr(section, text.find("\n## ", section) - section);
    EXPECT_THAT(body, HasSubstr("`" + column + "`")) << table;
  }
  EXPECT_GT(count, 70);
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

TEST_F(StoreTest, IsNotOpenedFromAnotherVersion) {
  Store::create(file(), {});
  SQLite::Database(file().string(), SQLite::OPEN_READWRITE).exec("PRAGMA user_version = 1");
  expect_complaint(error_of([&] { Store::open(file()); }), file(),
                   "results of version 1; this program reads version 4");
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
