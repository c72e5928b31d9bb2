// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/store_rows.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "eval/records/records.h"
#include "eval/results/store_schema.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr int kSqliteConstraint = 19;  // SQLite's header stays out of sight as SQLiteCpp does

using Covariance = Eigen::Matrix<double, 6, 6>;
constexpr size_t kCovarianceNumbers = 21;  // of a symmetric 6 by 6 matrix

const std::string kNoneRemoved = "[]";

// Writes the columns of a row from left to right.
class RowWriter {
 public:
  RowWriter(const SQLite::Database& database, const StoreTable& table)
      : insert_(database, insert_into(table)) {}

  template <typename Value>
  RowWriter& operator<<(const Value& value) {
    insert_.bind(++column_, value);
    return *this;
  }

  template <Named Enum>
  RowWriter& operator<<(const Enum& value) {
    return *this << std::string(to_string(value));
  }

  // NULL where there is no value.
  template <typename Value>
  RowWriter& operator<<(const std::optional<Value>& value) {
    return value ? *this << *value : write_nulls(1);
  }

  // As a JSON array.
  RowWriter& operator<<(const std::vector<std::string>& texts) {
    return *this << (texts.empty() ? kNoneRemoved : nlohmann::json(texts).dump());
  }

  RowWriter& operator<<(const Eigen::Vector2d& v) { return *this << v.x() << v.y(); }

  RowWriter& operator<<(const Pose& pose) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) *this << pose.rotation(row, column);
    }
    return *this << pose.translation.x() << pose.translation.y() << pose.translation.z();
  }

  // The upper triangle by rows.
  RowWriter& operator<<(const Covariance& covariance) {
    std::array<double, kCovarianceNumbers> numbers;
    size_t next = 0;
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) numbers[next++] = covariance(row, column);
    }
    insert_.bind(++column_, numbers.data(), sizeof numbers);
    return *this;
  }

  RowWriter& write_nulls(size_t count) {
    for (size_t i = 0; i < count; ++i) insert_.bind(++column_);
    return *this;
  }

  // The columns of a record's fields.
  template <typename Record, size_t kCount>
  RowWriter& write(const std::array<Field<Record>, kCount>& fields, const Record& record) {
    for (const Field<Record>& field : fields) {
      std::visit([&](auto member) { *this << record.*member; }, field.member);
    }
    return *this;
  }

  void end_row() {
    insert_.exec();
    insert_.reset();
    column_ = 0;
  }

 private:
  static std::string insert_into(const StoreTable& table) {
    const std::vector<std::string> names = table.column_names();
    const std::vector<const char*> values(names.size(), "?");
    return fmt::format("INSERT INTO {} ({}) VALUES ({})", table.name, fmt::join(names, ","),
                       fmt::join(values, ","));
  }

  SQLite::Statement insert_;
  int column_ = 0;
};

// Reads the rows of a table in the order of its keys, and the columns of a row from left to right.
class RowReader {
 public:
  RowReader(const SQLite::Database& database, const StoreTable& table)
      : select_(database, select_from(database, table)) {}

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
  template <Named Enum>
  RowReader& operator>>(Enum& value) {
    value = from_string<Enum>(next_column().getString());
    return *this;
  }
  template <typename Value>
  RowReader& operator>>(std::optional<Value>& value) {
    if (select_.getColumn(column_).isNull()) {
      ++column_;
      value.reset();
      return *this;
    }
    return *this >> value.emplace();
  }
  RowReader& operator>>(std::vector<std::string>& texts) {
    const std::string json = next_column().getString();
    texts.clear();
    if (json.empty() || json == kNoneRemoved) return *this;
    texts = nlohmann::json::parse(json).get<std::vector<std::string>>();
    return *this;
  }
  RowReader& operator>>(Covariance& covariance) {
    const SQLite::Column column = next_column();
    std::array<double, kCovarianceNumbers> numbers;
    if (column.getBytes() != sizeof numbers) {
      throw SQLite::Exception("a covariance of the wrong size");
    }
    std::memcpy(numbers.data(), column.getBlob(), sizeof numbers);
    size_t next = 0;
    for (int i = 0; i < 6; ++i) {
      for (int k = i; k < 6; ++k) {
        covariance(i, k) = numbers[next];
        covariance(k, i) = numbers[next++];
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

  // The columns of a record's fields.
  template <typename Record, size_t kCount>
  void read(const std::array<Field<Record>, kCount>& fields, Record& record) {
    for (const Field<Record>& field : fields) {
      std::visit([&](auto member) { *this >> record.*member; }, field.member);
    }
  }

 private:
  // With NULL in place of the columns that the table of an older schema lacks.
  static std::string select_from(const SQLite::Database& database, const StoreTable& table) {
    const std::vector<std::string> lacking = columns_there(database, table).lacking;
    std::vector<std::string> columns = table.column_names();
    for (std::string& name : columns) {
      if (std::find(lacking.begin(), lacking.end(), name) != lacking.end()) name = "NULL";
    }
    return fmt::format("SELECT {} FROM {} ORDER BY {}", fmt::join(columns, ","), table.name,
                       table.key);
  }

  SQLite::Column next_column() { return select_.getColumn(column_++); }

  SQLite::Statement select_;
  int column_ = 0;
};

// Prepared inserts, to be used within one transaction.
class TrialWriter {
 public:
  explicit TrialWriter(const SQLite::Database& database)
      : trials_(database, trials_table()),
        observations_(database, observations_table()),
        lines_(database, lines_table()),
        estimates_(database, estimates_table()),
        orientations_(database, orientations_table()) {}

  void write_trial(const TrialRecord& record) {
    trials_ << record.trial;
    trials_.write(kTrialFields, record);
    if (const auto* pose_trial = std::get_if<PoseTrial>(&record.kind)) {
      trials_.write(kPoseTrialFields, *pose_trial);
    } else {
      for (const auto& field : kPoseTrialFields) {
        trials_.write_nulls(component_names(field, PoseAs::kMatrix).size());
      }
    }
    trials_.end_row();
  }

  void write_lists(const TrialRecord& record) {
    write_list(observations_, kObservationFields, record.trial, record.observations());
    write_list(lines_, kLineFields, record.trial, record.lines());
    write_list(estimates_, kEstimateFields, record.trial, record.estimates());
    write_list(orientations_, kOrientationFields, record.trial, record.orientations());
  }

 private:
  template <typename Record, size_t kCount>
  static void write_list(RowWriter& rows, const std::array<Field<Record>, kCount>& fields,
                         int64_t trial, std::span<const Record> records) {
    int position = 0;
    for (const Record& record : records) {
      rows << trial << position++;
      rows.write(fields, record);
      rows.end_row();
    }
  }

  RowWriter trials_;
  RowWriter observations_;
  RowWriter lines_;
  RowWriter estimates_;
  RowWriter orientations_;
};

// A table that has rows of many trials, which are handed out trial by trial: both are ordered by
// the trial's number, so one pass does.
template <typename Record, size_t kCount>
class TrialRows {
 public:
  TrialRows(const SQLite::Database& database, const StoreTable& table,
            const std::array<Field<Record>, kCount>& fields)
      : fields_(fields) {
    if (!table.is_required && columns_there(database, table).there.empty()) return;
    rows_.emplace(database, table);
    advance();
  }

  std::vector<Record> rows_of(int64_t trial) {
    // Foreign keys leave no row without its trial, but a file may have been edited without them.
    while (has_row_ && trial_ < trial) advance();
    std::vector<Record> records;
    for (; has_row_ && trial_ == trial; advance()) {
      rows_->read(fields_, records.emplace_back());
    }
    return records;
  }

 private:
  void advance() {
    has_row_ = rows_->next_row();
    int position = 0;
    if (has_row_) *rows_ >> trial_ >> position;
  }

  std::optional<RowReader> rows_;  // none of a table that the store does not have
  const std::array<Field<Record>, kCount>& fields_;
  bool has_row_ = false;
  int64_t trial_ = 0;
};

}  // namespace

void write_trials(SQLite::Database& database, std::span<const TrialRecord> trials,
                  const std::string& file) {
  TrialWriter writer(database);
  for (const TrialRecord& record : trials) {
    try {
      writer.write_trial(record);
    } catch (const SQLite::Exception& error) {
      if (error.getErrorCode() != kSqliteConstraint) throw;
      throw InputError(fmt::format("{}: holds trial {} already", file, record.trial));
    }
    writer.write_lists(record);
  }
}

void visit_trials(const SQLite::Database& database, const TrialVisitor& visit) {
  RowReader trials(database, trials_table());
  TrialRows observations(database, observations_table(), kObservationFields);
  TrialRows lines(database, lines_table(), kLineFields);
  TrialRows estimates(database, estimates_table(), kEstimateFields);
  TrialRows orientations(database, orientations_table(), kOrientationFields);
  while (trials.next_row()) {
    TrialRecord record;
    PoseTrial pose_trial;
    trials >> record.trial;
    trials.read(kTrialFields, record);
    trials.read(kPoseTrialFields, pose_trial);
    pose_trial.observations = observations.rows_of(record.trial);
    pose_trial.lines = lines.rows_of(record.trial);
    pose_trial.estimates = estimates.rows_of(record.trial);
    OrientationTrial orientation_trial{orientations.rows_of(record.trial)};
    if (orientation_trial.orientations.empty()) {
      record.kind = std::move(pose_trial);
    } else {
      record.kind = std::move(orientation_trial);
    }
    visit(record);
  }
}

}  // namespace sightline
