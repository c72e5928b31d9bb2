// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/results_csv.h"

#include <array>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/records/columns.h"

namespace sightline {
namespace {

// Fields of a line, quoted where they have to be.
class Line {
 public:
  Line& operator<<(const std::string& text) { return *this << std::string_view(text); }
  Line& operator<<(const char* text) { return *this << std::string_view(text); }
  Line& operator<<(std::string_view text) {
    begin_field();
    if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
      text_ += text;
      return *this;
    }
    text_ += '"';
    for (const char c : text) {
      if (c == '"') text_ += '"';
      text_ += c;
    }
    text_ += '"';
    return *this;
  }

  // The shortest number that reads back the same.
  Line& operator<<(double number) {
    begin_field();
    fmt::format_to(std::back_inserter(text_), "{}", number);
    return *this;
  }

  Line& operator<<(int64_t number) {
    begin_field();
    fmt::format_to(std::back_inserter(text_), "{}", number);
    return *this;
  }

  Line& operator<<(int number) { return *this << int64_t{number}; }

  Line& operator<<(bool is) { return *this << int64_t{is}; }

  template <Named Enum>
  Line& operator<<(Enum value) {
    return *this << to_string(value);
  }

  // Empty where there is no value.
  template <typename Value>
  Line& operator<<(const std::optional<Value>& value) {
    return value ? *this << *value : *this << std::string_view();
  }

  Line& operator<<(const std::vector<std::string>& names) {
    return *this << fmt::to_string(fmt::join(names, ";"));
  }

  Line& operator<<(const Eigen::Vector2d& v) { return *this << v.x() << v.y(); }

  // In one column, by rows.
  Line& operator<<(const Eigen::Matrix<double, 6, 6>& symmetric) {
    return *this << fmt::to_string(fmt::join(symmetric.reshaped(), ";"));
  }

  Line& operator<<(const Pose& pose) {
    for (const double q : quaternion_wxyz(pose.rotation)) *this << q;
    for (const double t : pose.translation) *this << t;
    return *this;
  }

  Line& empty_fields(size_t count) {
    for (size_t i = 0; i < count; ++i) *this << "";
    return *this;
  }

  std::string end() && { return std::move(text_) + "\n"; }

 private:
  void begin_field() {
    if (has_fields_) text_ += ',';
    has_fields_ = true;
  }

  std::string text_;
  bool has_fields_ = false;
};

// A column that no record holds.
struct Extra {
  std::string_view name;
  std::string_view meaning;
};

constexpr std::array kTrial = {
    Extra{"trial", "the trial's number, which draws it"},
    Extra{"condition", "the label of the study's condition that it belongs to"}};
// Of a trial whose image is a data set's.
constexpr std::array kSighting = {Extra{"image", "the picture's path within the data set"},
                                  Extra{"scene_id", "as BOP numbers it"},
                                  Extra{"im_id", "as BOP numbers it"},
                                  Extra{"gt_id", "place of the instance in its image's truth"}};
constexpr std::array kCounts = {Extra{"found", "features that were found in the trial"},
                                Extra{"outliers", "how many of them are outliers"}};
constexpr std::array kCopies = {Extra{"copies", "noisy copies of the points, which were solved"}};

std::set<std::string> condition_keys(const Study& study) {
  std::set<std::string> keys;
  for (const Condition& condition : study.conditions) {
    for (const auto& [key, value] : condition.values) keys.insert(key);
    for (const auto& [key, word] : condition.words) keys.insert(key);
  }
  return keys;
}

// Puts columns together from left to right.
class Layout {
 public:
  explicit Layout(const std::set<std::string>& keys) {
    add(kTrial);
    for (const std::string& key : keys) {
      columns_.push_back({{key}, "", "the condition's value of this key of the study"});
    }
  }

  Layout& add(std::span<const Extra> extras) {
    for (const Extra& extra : extras) {
      columns_.push_back({{std::string(extra.name)}, "", std::string(extra.meaning)});
    }
    return *this;
  }

  // The fields of a record that stand at that place of a row.
  template <typename Record, size_t kCount>
  Layout& add(const std::array<Field<Record>, kCount>& fields, CsvPlace place) {
    for (const Field<Record>& field : fields) {
      if (field.csv != place) continue;
      CsvColumns& columns = columns_.emplace_back();
      for (const std::string_view component : component_names(field, PoseAs::kQuaternion)) {
        columns.names.push_back(fmt::format("{}{}", field.csv_name, component));
      }
      columns.unit = field.unit;
      columns.meaning = field.meaning;
    }
    return *this;
  }

  std::vector<CsvColumns> columns() && { return std::move(columns_); }

 private:
  std::vector<CsvColumns> columns_;
};

std::string header(const std::vector<CsvColumns>& columns) {
  Line line;
  for (const CsvColumns& column : columns) {
    for (const std::string& name : column.names) line << name;
  }
  return std::move(line).end();
}

// The same fields of a record as Layout::add() names. Measures (numbers with decimals, and poses)
// stay empty where they mean nothing.
template <typename Record, size_t kCount>
void write_fields(Line& line, const std::array<Field<Record>, kCount>& fields, CsvPlace place,
                  const Record& record, bool has_measures = true) {
  for (const Field<Record>& field : fields) {
    if (field.csv != place) continue;
    const auto write = [&](auto member) {
      using Value = std::remove_cvref_t<decltype(record.*member)>;
      constexpr bool is_measure = std::is_same_v<Value, double> || std::is_same_v<Value, Pose>;
      if (is_measure && !has_measures) {
        line.empty_fields(component_names(field, PoseAs::kQuaternion).size());
      } else {
        line << record.*member;
      }
    };
    std::visit(write, field.member);
  }
}

// What a trial's images gave.
struct Counts {
  int found = 0;
  int outliers = 0;
};

Counts count_observations(const TrialRecord& trial) {
  Counts counts;
  for (const ObservationRecord& observation : trial.observations()) {
    counts.found += observation.is_found();
    counts.outliers += observation.is_outlier;
  }
  return counts;
}

void write_condition(Line& line, const Condition& condition, const std::set<std::string>& keys,
                     const TrialRecord& trial) {
  line << trial.trial << condition.label;
  for (const std::string& key : keys) {
    const auto value = condition.values.find(key);
    const auto word = condition.words.find(key);
    if (value != condition.values.end()) {
      line << value->second;
    } else {
      line << (word != condition.words.end() ? word->second : "");
    }
  }
}

void write_sighting(Line& line, const Sighting& sighting) {
  line << sighting.image << sighting.scene_id << sighting.im_id << sighting.gt_id;
}

// A failed estimate as it counts: it removed nothing, and missed every outlier.
EstimateRecord as_counted(const EstimateRecord& estimate, const Counts& counts) {
  if (estimate.is_ok()) return estimate;
  EstimateRecord counted;
  counted.solver = estimate.solver;
  counted.status = estimate.status;
  counted.missed_outliers = counts.outliers;
  return counted;
}

// In the order of estimate_columns().
void write_estimate(Line& line, const TrialRecord& trial, const Counts& counts,
                    const EstimateRecord& estimate) {
  const bool is_ok = estimate.is_ok();
  const EstimateRecord counted = as_counted(estimate, counts);
  for (const CsvPlace place : {CsvPlace::kSolver, CsvPlace::kStatus, CsvPlace::kResult}) {
    write_fields(line, kEstimateFields, place, counted, is_ok);
  }
  line << counts.found << counts.outliers;
  write_fields(line, kEstimateFields, CsvPlace::kPose, counted, is_ok);
  write_fields(line, kTrialFields, CsvPlace::kPose, trial);
  write_fields(line, kEstimateFields, CsvPlace::kEnd, counted, is_ok);
}

// In the order of orientation_columns().
void write_orientation(Line& line, const Study& study, const TrialRecord& trial,
                       const OrientationRecord& orientation) {
  write_fields(line, kOrientationFields, CsvPlace::kSolver, orientation);
  write_fields(line, kOrientationFields, CsvPlace::kStatus, orientation);
  line << study.pairs.copies;
  write_fields(line, kOrientationFields, CsvPlace::kResult, orientation);
  write_fields(line, kTrialFields, CsvPlace::kPose, trial);
  write_fields(line, kOrientationFields, CsvPlace::kEnd, orientation);
}

void write_orientation_csv(const Study& study, const TrialSource& trials, std::ostream& out) {
  const std::set<std::string> keys = condition_keys(study);
  out << header(orientation_columns(keys));
  trials([&](const TrialRecord& trial) {
    for (const OrientationRecord& orientation : trial.orientations()) {
      Line line;
      write_condition(line, study.conditions[trial.condition], keys, trial);
      write_orientation(line, study, trial, orientation);
      out << std::move(line).end();
    }
  });
}

}  // namespace

std::vector<CsvColumns> estimate_columns(const std::set<std::string>& keys, bool has_sightings) {
  Layout layout(keys);
  if (has_sightings) layout.add(kSighting);
  return std::move(layout.add(kEstimateFields, CsvPlace::kSolver)
                       .add(kEstimateFields, CsvPlace::kStatus)
                       .add(kEstimateFields, CsvPlace::kResult)
                       .add(kCounts)
                       .add(kEstimateFields, CsvPlace::kPose)
                       .add(kTrialFields, CsvPlace::kPose)
                       .add(kEstimateFields, CsvPlace::kEnd))
      .columns();
}

std::vector<CsvColumns> orientation_columns(const std::set<std::string>& keys) {
  return std::move(Layout(keys)
                       .add(kOrientationFields, CsvPlace::kSolver)
                       .add(kOrientationFields, CsvPlace::kStatus)
                       .add(kCopies)
                       .add(kOrientationFields, CsvPlace::kResult)
                       .add(kTrialFields, CsvPlace::kPose)
                       .add(kOrientationFields, CsvPlace::kEnd))
      .columns();
}

std::vector<CsvColumns> timing_columns(const std::set<std::string>& keys) {
  return std::move(Layout(keys)
                       .add(kOrientationFields, CsvPlace::kSolver)
                       .add(kOrientationFields, CsvPlace::kTiming))
      .columns();
}

void write_csv(const Study& study, const TrialSource& trials, std::ostream& out) {
  if (study.kind == StudyKind::kOrientation) return write_orientation_csv(study, trials, out);
  const std::set<std::string> keys = condition_keys(study);
  out << header(estimate_columns(keys, !!study.sightings));
  trials([&](const TrialRecord& trial) {
    const Counts counts = count_observations(trial);
    for (const EstimateRecord& estimate : trial.estimates()) {
      Line line;
      write_condition(line, study.conditions[trial.condition], keys, trial);
      if (study.sightings) write_sighting(line, study.sighting_of(trial.trial));
      write_estimate(line, trial, counts, estimate);
      out << std::move(line).end();
    }
  });
}

void write_timings_csv(const Study& study, const TrialSource& trials, std::ostream& out) {
  const std::set<std::string> keys = condition_keys(study);
  out << header(timing_columns(keys));
  trials([&](const TrialRecord& trial) {
    for (const OrientationRecord& orientation : trial.orientations()) {
      Line line;
      write_condition(line, study.conditions[trial.condition], keys, trial);
      write_fields(line, kOrientationFields, CsvPlace::kSolver, orientation);
      write_fields(line, kOrientationFields, CsvPlace::kTiming, orientation);
      out << std::move(line).end();
    }
  });
}

}  // namespace sightline
