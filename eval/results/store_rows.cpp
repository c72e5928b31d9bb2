// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/store_rows.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
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
      : table_(table.name), select_(database, select_from(database, table)) {}

  bool next_row() {
    column_ = 0;
    return select_.executeStep();
  }

  // Columns hold whatever was put there, and SQLite reads a text as the number 0: what is of
  // another kind is refused. NULL, where a column is lacking, is 0, and NaN as a double.
  RowReader& operator>>(int64_t& value) {
    const SQLite::Column column = next_column();
    if (!column.isNull() && !column.isInteger()) fail_as_no("whole number");
    value = column.getInt64();
    return *this;
  }
  RowReader& operator>>(int& value) {
    int64_t whole = 0;
    *this >> whole;
    if (whole != static_cast<int>(whole)) fail_as_no("whole number below 2^31");
    value = static_cast<int>(whole);
    return *this;
  }
  RowReader& operator>>(bool& value) {
    int64_t whole = 0;
    *this >> whole;
    if (whole != 0 && whole != 1) fail_as_no("0 or 1");
    value = whole == 1;
    return *this;
  }
  RowReader& operator>>(double& value) {
    const SQLite::Column column = next_column();
    if (column.isText() || column.isBlob()) fail_as_no("number");
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

  // Of the column that was read last.
  [[noreturn]] void fail_as_no(const char* kind) {
    throw SQLite::Exception(fmt::format("table {} has a row whose {} is no {}", table_,
                                        select_.getColumnName(column_ - 1), kind));
  }

  const char* table_;
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
      : name_(table.name), fields_(fields) {
    if (!table.is_required && columns_there(database, table).there.empty()) return;
    rows_.emplace(database, table);
    advance();
  }

  std::vector<Record> rows_of(int64_t trial) {
    require_no_row_before(trial);
    std::vector<Record> records;
    for (; has_row_ && trial_ == trial; advance()) {
      if (position_ != static_cast<int64_t>(records.size())) {
        throw SQLite::Exception(
            fmt::format("table {} lacks position {} of trial {}", name_, records.size(), trial));
      }
      rows_->read(fields_, records.emplace_back());
    }
    return records;
  }

  // Foreign keys leave no row without its trial, but a file may have been edited without them.
  void require_no_row_before(int64_t trial) const {
    if (!has_row_ || trial_ >= trial) return;
    throw SQLite::Exception(
        fmt::format("table {} has a row of trial {}, which table trials has not", name_, trial_));
  }

 private:
  void advance() {
    has_row_ = rows_->next_row();
    if (has_row_) *rows_ >> trial_ >> position_;
  }

  const char* name_;
  std::optional<RowReader> rows_;  // none of a table that the store does not have
  const std::array<Field<Record>, kCount>& fields_;
  bool has_row_ = false;
  int64_t trial_ = 0;
  int64_t position_ = 0;
};

// All tables, gone through together.
class TrialCursor {
 public:
  explicit TrialCursor(const SQLite::Database& database)
      : trials_(database, trials_table()),
        observations_(database, observations_table(), kObservationFields),
        lines_(database, lines_table(), kLineFields),
        estimates_(database, estimates_table(), kEstimateFields),
        orientations_(database, orientations_table(), kOrientationFields) {}

  std::optional<TrialRecord> next() {
    if (!trials_.next_row()) {
      require_no_row_left();
      return std::nullopt;
    }
    TrialRecord record;
    PoseTrial pose_trial;
    trials_ >> record.trial;
    trials_.read(kTrialFields, record);
    trials_.read(kPoseTrialFields, pose_trial);
    pose_trial.observations = observations_.rows_of(record.trial);
    pose_trial.lines = lines_.rows_of(record.trial);
    pose_trial.estimates = estimates_.rows_of(record.trial);
    OrientationTrial orientation_trial{orientations_.rows_of(record.trial)};
    if (orientation_trial.orientations.empty()) {
      record.kind = std::move(pose_trial);
    } else {
      record.kind = std::move(orientation_trial);
    }
    return record;
  }

 private:
  void require_no_row_left() const {
    constexpr int64_t kAfterAll = std::numeric_limits<int64_t>::max();
    observations_.require_no_row_before(kAfterAll);
    lines_.require_no_row_before(kAfterAll);
    estimates_.require_no_row_before(kAfterAll);
    orientations_.require_no_row_before(kAfterAll);
  }

  RowReader trials_;
  TrialRows<ObservationRecord, kObservationFields.size()> observations_;
  TrialRows<LineRecord, kLineFields.size()> lines_;
  TrialRows<EstimateRecord, kEstimateFields.size()> estimates_;
  TrialRows<OrientationRecord, kOrientationFields.size()> orientations_;
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

NextTrial trial_reader(const SQLite::Database& database) {
  return [cursor = std::make_shared<TrialCursor>(database)] { return cursor->next(); };
}

}  // namespace sightline
