// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/store.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <utility>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

// The schema, which docs/store.md explains. Columns of doubles have no type on purpose: SQLite
// writes them as they are, while in a column of type REAL it turns -0 into 0.
constexpr int kApplicationId = 0x53474854;  // "SGHT"
constexpr int kSchemaVersion = 4;
constexpr const char* kSchema = R"sql(
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;

CREATE TABLE trials (
  trial INTEGER PRIMARY KEY, condition INTEGER NOT NULL, redraws INTEGER NOT NULL,
  true_r00, true_r01, true_r02, true_r10, true_r11, true_r12, true_r20, true_r21, true_r22,
  true_tx_m, true_ty_m, true_tz_m,
  prior_r00, prior_r01, prior_r02, prior_r10, prior_r11, prior_r12, prior_r20, prior_r21, prior_r22,
  prior_tx_m, prior_ty_m, prior_tz_m
);

CREATE TABLE observations (
  trial INTEGER NOT NULL REFERENCES trials, position INTEGER NOT NULL,
  feature TEXT NOT NULL, status TEXT NOT NULL, is_visible INTEGER NOT NULL,
  pixel_u, pixel_v, true_pixel_u, true_pixel_v, error_px, error_sigmas,
  is_outlier INTEGER NOT NULL, label TEXT NOT NULL,
  PRIMARY KEY (trial, position)
) WITHOUT ROWID;

CREATE TABLE estimates (
  trial INTEGER NOT NULL REFERENCES trials, position INTEGER NOT NULL,
  solver TEXT NOT NULL, status TEXT NOT NULL,
  r00, r01, r02, r10, r11, r12, r20, r21, r22, tx_m, ty_m, tz_m,
  theta_error_deg, t_error_percent, geodesic_deg, reprojection_rms_px, add_m, mssd_m, mspd_px,
  removed TEXT NOT NULL, false_removals INTEGER NOT NULL, missed_outliers INTEGER NOT NULL,
  covariance BLOB, nees,
  PRIMARY KEY (trial, position)
) WITHOUT ROWID;

CREATE TABLE orientations (
  trial INTEGER NOT NULL REFERENCES trials, position INTEGER NOT NULL,
  method TEXT NOT NULL, status TEXT NOT NULL, failures INTEGER NOT NULL,
  angle_error_deg, theta_error_deg, t_error_percent, geodesic_deg, time_ns,
  PRIMARY KEY (trial, position)
) WITHOUT ROWID;
)sql";

// Primary result codes of SQLite, whose header stays out of sight as SQLiteCpp does.
constexpr int kSqliteConstraint = 19;
constexpr int kSqliteNotADatabase = 26;

const std::string kNoneRemoved = "[]";
constexpr size_t kCovarianceNumbers = 21;  // of a symmetric 6 by 6 matrix

// For another process that looks into the file.
constexpr int kMostWaitMs = 30'000;

// Writes the columns of a row from left to right.
class RowWriter {
 public:
  RowWriter(const SQLite::Database& database, const std::string& table, int columns)
      : insert_(database, insert_into(table, columns)) {}

  template <typename Value>
  RowWriter& operator<<(const Value& value) {
    insert_.bind(++column_, value);
    return *this;
  }

  RowWriter& operator<<(const Eigen::Vector2d& v) { return *this << v.x() << v.y(); }

  RowWriter& operator<<(const Pose& pose) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) *this << pose.rotation(row, column);
    }
    return *this << pose.translation.x() << pose.translation.y() << pose.translation.z();
  }

  // The upper triangle by rows, or NULL.
  RowWriter& operator<<(const std::optional<Eigen::Matrix<double, 6, 6>>& covariance) {
    if (!covariance) {
      insert_.bind(++column_);
      return *this;
    }
    std::array<double, kCovarianceNumbers> numbers;
    size_t next = 0;
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) numbers[next++] = (*covariance)(row, column);
    }
    insert_.bind(++column_, numbers.data(), sizeof numbers);
    return *this;
  }

  void end_row() {
    insert_.exec();
    insert_.reset();
    column_ = 0;
  }

 private:
  static std::string insert_into(const std::string& table, int columns) {
    std::string values = "?";
    for (int i = 1; i < columns; ++i) values += ",?";
    return fmt::format("INSERT INTO {} VALUES ({})", table, values);
  }

  SQLite::Statement insert_;
  int column_ = 0;
};

// Reads the rows of a table in the order of `order`, and the columns of a row from left to right.
class RowReader {
 public:
  RowReader(const SQLite::Database& database, const std::string& table, const std::string& order)
      : select_(database, fmt::format("SELECT * FROM {} ORDER BY {}", table, order)) {}

  bool next_row() {
    column_ = 0;
    return select_.executeStep();
  }

  RowReader& operator>>(int64_t& value) {
    value = next_column().getInt64();
    return *this;
  }
  RowReader& operator>>(int& value) {
    value = next_column().getInt();
    return *this;
  }
  RowReader& operator>>(bool& value) {
    value = next_column().getInt() != 0;
    return *this;
  }
  RowReader& operator>>(double& value) {
    const SQLite::Column column = next_column();
    value = column.isNull() ? std::numeric_limits<double>::quiet_NaN() : column.getDouble();
    return *this;
  }
  RowReader& operator>>(std::string& value) {
    value = next_column().getString();
    return *this;
  }
  RowReader& operator>>(std::optional<Eigen::Matrix<double, 6, 6>>& covariance) {
    const SQLite::Column column = next_column();
    std::array<double, kCovarianceNumbers> numbers;
    covariance.reset();
    if (column.isNull() || column.getBytes() != sizeof numbers) return *this;
    std::memcpy(numbers.data(), column.getBlob(), sizeof numbers);
    covariance.emplace();
    size_t next = 0;
    for (int i = 0; i < 6; ++i) {
      for (int k = i; k < 6; ++k) {
        (*covariance)(i, k) = numbers[next];
        (*covariance)(k, i) = numbers[next++];
      }
    }
    return *this;
  }
  RowReader& operator>>(Eigen::Vector2d& v) { return *this >> v.x() >> v.y(); }
  RowReader& operator>>(Pose& pose) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) *this >> pose.rotation(row, column);
    }
    return *this >> pose.translation.x() >> pose.translation.y() >> pose.translation.z();
  }

 private:
  SQLite::Column next_column() { return select_.getColumn(column_++); }

  SQLite::Statement select_;
  int column_ = 0;
};

// Prepared inserts, to be used within one transaction.
class TrialWriter {
 public:
  explicit TrialWriter(const SQLite::Database& database)
      : trials_(database, "trials", 27),
        observations_(database, "observations", 13),
        estimates_(database, "estimates", 28),
        orientations_(database, "orientations", 10) {}

  void write_trial(const TrialRecord& record) {
    trials_ << record.trial << record.condition << record.redraws << record.true_cam_from_target
            << record.prior_cam_from_target;
    trials_.end_row();
  }

  void write_observations(const TrialRecord& record) {
    int position = 0;
    for (const ObservationRecord& o : record.observations) {
      observations_ << record.trial << position++ << o.feature << o.status << o.is_visible
                    << o.pixel << o.true_pixel << o.error_px << o.error_sigmas << o.is_outlier
                    << o.label;
      observations_.end_row();
    }
  }

  void write_estimates(const TrialRecord& record) {
    int position = 0;
    for (const EstimateRecord& e : record.estimates) {
      estimates_ << record.trial << position++ << e.solver << e.status << e.cam_from_target
                 << e.theta_error_deg << e.t_error_percent << e.geodesic_deg
                 << e.reprojection_rms_px << e.add_m << e.mssd_m << e.mspd_px
                 << (e.removed.empty() ? kNoneRemoved : nlohmann::json(e.removed).dump())
                 << e.false_removals << e.missed_outliers << e.covariance << e.nees;
      estimates_.end_row();
    }
  }

  void write_orientations(const TrialRecord& record) {
    int position = 0;
    for (const OrientationRecord& o : record.orientations) {
      orientations_ << record.trial << position++ << o.method << o.status << o.failures
                    << o.angle_error_deg << o.theta_error_deg << o.t_error_percent << o.geodesic_deg
                    << o.time_ns;
      orientations_.end_row();
    }
  }

 private:
  RowWriter trials_;
  RowWriter observations_;
  RowWriter estimates_;
  RowWriter orientations_;
};

void read_observation(RowReader& row, TrialRecord& record) {
  ObservationRecord& o = record.observations.emplace_back();
  row >> o.feature >> o.status >> o.is_visible >> o.pixel >> o.true_pixel >> o.error_px >>
      o.error_sigmas >> o.is_outlier >> o.label;
}

void read_estimate(RowReader& row, TrialRecord& record) {
  EstimateRecord& e = record.estimates.emplace_back();
  std::string removed;
  row >> e.solver >> e.status >> e.cam_from_target >> e.theta_error_deg >> e.t_error_percent >>
      e.geodesic_deg >> e.reprojection_rms_px >> e.add_m >> e.mssd_m >> e.mspd_px >> removed >>
      e.false_removals >> e.missed_outliers >> e.covariance >> e.nees;
  if (removed == kNoneRemoved) return;
  e.removed = nlohmann::json::parse(removed).get<std::vector<std::string>>();
}

void read_orientation(RowReader& row, TrialRecord& record) {
  OrientationRecord& o = record.orientations.emplace_back();
  row >> o.method >> o.status >> o.failures >> o.angle_error_deg >> o.theta_error_deg >>
      o.t_error_percent >> o.geodesic_deg >> o.time_ns;
}

// A table that has rows of many trials, which are handed out trial by trial: both are ordered by
// the trial's number, so one pass does.
class TrialRows {
 public:
  using ReadRow = void (*)(RowReader& row, TrialRecord& record);

  TrialRows(const SQLite::Database& database, const std::string& table, ReadRow read_row)
      : rows_(database, table, "trial, position"), read_row_(read_row) {
    advance();
  }

  void read_into(TrialRecord& record) {
    // Foreign keys leave no row without its trial, but a file may have been edited without them.
    while (has_row_ && trial_ < record.trial) advance();
    for (; has_row_ && trial_ == record.trial; advance()) read_row_(rows_, record);
  }

 private:
  void advance() {
    has_row_ = rows_.next_row();
    int position = 0;
    if (has_row_) rows_ >> trial_ >> position;
  }

  RowReader rows_;
  ReadRow read_row_;
  bool has_row_ = false;
  int64_t trial_ = 0;
};

void visit_trials(const SQLite::Database& database, const TrialVisitor& visit) {
  RowReader trials(database, "trials", "trial");
  std::array tables{TrialRows(database, "observations", read_observation),
                    TrialRows(database, "estimates", read_estimate),
                    TrialRows(database, "orientations", read_orientation)};
  while (trials.next_row()) {
    TrialRecord record;
    trials >> record.trial >> record.condition >> record.redraws >> record.true_cam_from_target >>
        record.prior_cam_from_target;
    for (TrialRows& table : tables) table.read_into(record);
    visit(record);
  }
}

// Runs `action`; what SQLite says went wrong becomes an InputError about the file.
template <typename Action>
auto on_file(const std::filesystem::path& file, const char* what_failed, const Action& action) {
  try {
    return action();
  } catch (const SQLite::Exception& error) {
    if (error.getErrorCode() == kSqliteNotADatabase) {
      throw InputError(fmt::format("{}: not an SQLite file", file.string()));
    }
    throw InputError(fmt::format("{}: {} ({})", file.string(), what_failed, error.what()));
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("{}: {} ({})", file.string(), what_failed, error.what()));
  }
}

// Makes an empty file, which is an empty SQLite database.
void make_empty_file(const std::filesystem::path& file) {
  std::FILE* const handle = std::fopen(file.c_str(), "w");
  if (handle == nullptr) {
    throw InputError(fmt::format("{}: cannot be created ({})", file.string(), strerror(errno)));
  }
  std::fclose(handle);
}

void write_schema(SQLite::Database& database, const std::map<std::string, std::string>& meta) {
  SQLite::Transaction transaction(database);
  database.exec(kSchema);
  database.exec(fmt::format("PRAGMA application_id = {}", kApplicationId));
  database.exec(fmt::format("PRAGMA user_version = {}", kSchemaVersion));
  RowWriter rows(database, "meta", 2);
  for (const auto& [key, value] : meta) {
    rows << key << value;
    rows.end_row();
  }
  transaction.commit();
}

void check_version(SQLite::Database& database, const std::filesystem::path& file) {
  if (database.execAndGet("PRAGMA application_id").getInt() != kApplicationId) {
    throw InputError(fmt::format("{}: an SQLite file, but not one of sightline's", file.string()));
  }
  const int version = database.execAndGet("PRAGMA user_version").getInt();
  if (version == kSchemaVersion) return;
  throw InputError(fmt::format("{}: results of version {}; this program reads version {}",
                               file.string(), version, kSchemaVersion));
}

}  // namespace

struct Store::Impl {
  // The default journal is named because the faster one (WAL) breaks on network file systems.
  explicit Impl(std::filesystem::path path)
      : file(std::move(path)),
        database(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_NOMUTEX, kMostWaitMs) {
    database.exec("PRAGMA journal_mode = DELETE");
    database.exec("PRAGMA foreign_keys = ON");
  }

  std::filesystem::path file;
  SQLite::Database database;
};

Store::Store(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Store::Store(Store&&) noexcept = default;
Store& Store::operator=(Store&&) noexcept = default;
Store::~Store() = default;

Store Store::create(const std::filesystem::path& file,
                    const std::map<std::string, std::string>& meta) {
  if (std::filesystem::exists(file)) {
    throw InputError(fmt::format("{}: exists already; name a new file", file.string()));
  }
  const std::filesystem::path partial = file.string() + ".partial";
  std::error_code error;
  std::filesystem::remove(partial.string() + "-journal", error);
  make_empty_file(partial);
  return on_file(file, "cannot be written", [&] {
    {
      Impl impl(partial);
      write_schema(impl.database, meta);
    }
    std::filesystem::rename(partial, file, error);
    if (error) {
      throw InputError(fmt::format("{}: cannot be created ({})", file.string(), error.message()));
    }
    return Store(std::make_unique<Impl>(file));
  });
}

Store Store::open(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file)) {
    const bool exists = std::filesystem::exists(file);
    throw InputError(fmt::format("{}: {}", file.string(), exists ? "not a file" : "no such file"));
  }
  return on_file(file, "cannot be read", [&] {
    auto impl = std::make_unique<Impl>(file);
    check_version(impl->database, file);
    return Store(std::move(impl));
  });
}

void Store::add(std::span<const TrialRecord> trials) {
  on_file(impl_->file, "cannot be written", [&] {
    SQLite::Transaction transaction(impl_->database);
    TrialWriter writer(impl_->database);
    for (const TrialRecord& record : trials) {
      try {
        writer.write_trial(record);
      } catch (const SQLite::Exception& error) {
        if (error.getErrorCode() != kSqliteConstraint) throw;
        throw InputError(
            fmt::format("{}: holds trial {} already", impl_->file.string(), record.trial));
      }
      writer.write_observations(record);
      writer.write_estimates(record);
      writer.write_orientations(record);
    }
    transaction.commit();
  });
}

void Store::add_all_of(const std::filesystem::path& file) {
  Store::open(file);  // says what is wrong with it, and rolls back what a killed writer left
  on_file(impl_->file, "cannot be written", [&] {
    SQLite::Database& database = impl_->database;
    SQLite::Statement attach(database, "ATTACH DATABASE ? AS other");
    attach.bind(1, file.string());
    attach.exec();
    {
      SQLite::Transaction transaction(database);
      for (const char* table : {"trials", "observations", "estimates", "orientations"}) {
        database.exec(fmt::format("INSERT INTO main.{0} SELECT * FROM other.{0}", table));
      }
      transaction.commit();
    }
    database.exec("DETACH DATABASE other");
  });
}

std::vector<TrialRecord> Store::trials() const {
  std::vector<TrialRecord> records;
  for_each([&records](const TrialRecord& record) { records.push_back(record); });
  return records;
}

void Store::for_each(const TrialVisitor& visit) const {
  on_file(impl_->file, "cannot be read", [&] { visit_trials(impl_->database, visit); });
}

int64_t Store::size() const {
  return on_file(impl_->file, "cannot be read", [&]() -> int64_t {
    return impl_->database.execAndGet("SELECT count(*) FROM trials").getInt64();
  });
}

std::vector<bool> Store::held(int64_t end) const {
  return on_file(impl_->file, "cannot be read", [&] {
    std::vector<bool> held(static_cast<size_t>(end));
    SQLite::Statement select(impl_->database, "SELECT trial FROM trials");
    while (select.executeStep()) {
      const int64_t trial = select.getColumn(0).getInt64();
      if (trial >= 0 && trial < end) held[static_cast<size_t>(trial)] = true;
    }
    return held;
  });
}

std::optional<int64_t> Store::first_trial() const {
  return on_file(impl_->file, "cannot be read", [&]() -> std::optional<int64_t> {
    SQLite::Statement select(impl_->database, "SELECT min(trial) FROM trials");
    if (!select.executeStep() || select.getColumn(0).isNull()) return std::nullopt;
    return select.getColumn(0).getInt64();
  });
}

bool Store::holds(int64_t trial) const {
  return on_file(impl_->file, "cannot be read", [&] {
    SQLite::Statement select(impl_->database, "SELECT 1 FROM trials WHERE trial = ?");
    select.bind(1, trial);
    return select.executeStep();
  });
}

std::map<std::string, std::string> Store::meta() const {
  return on_file(impl_->file, "cannot be read", [&] {
    std::map<std::string, std::string> meta;
    RowReader rows(impl_->database, "meta", "key");
    while (rows.next_row()) {
      std::string key;
      std::string value;
      rows >> key >> value;
      meta[key] = value;
    }
    return meta;
  });
}

}  // namespace sightline
