// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/results_csv.h"

#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/csv.h"
#include "eval/records/records.h"

namespace sightline {
namespace {

// The fields of a record's value, which may be several.
void put(CsvLine& line, const std::string& text) {
  line << std::string_view(text);
}
void put(CsvLine& line, double number) {
  line << number;
}
void put(CsvLine& line, int number) {
  line << number;
}
void put(CsvLine& line, bool is) {
  line << int64_t{is};
}
template <Named Enum>
void put(CsvLine& line, Enum value) {
  line << to_string(value);
}
void put(CsvLine& line, const std::vector<std::string>& names) {
  line << fmt::to_string(fmt::join(names, ";"));
}
void put(CsvLine& line, const Eigen::Vector2d& v) {
  line << v.x() << v.y();
}
// In one column, by rows.
void put(CsvLine& line, const Eigen::Matrix<double, 6, 6>& symmetric) {
  line << fmt::to_string(fmt::join(symmetric.reshaped(), ";"));
}
void put(CsvLine& line, const Pose& pose) {
  for (const double q : quaternion_wxyz(pose.rotation)) line << q;
  for (const double t : pose.translation) line << t;
}
// Empty where there is no value.
template <typename Value>
void put(CsvLine& line, const std::optional<Value>& value) {
  value ? put(line, *value) : put(line, std::string());
}

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
  CsvLine line;
  for (const CsvColumns& column : columns) {
    for (const std::string& name : column.names) line << name;
  }
  return std::move(line).end();
}

// The same fields of a record as Layout::add() names. Measures (numbers with decimals, and poses)
// stay empty where they mean nothing.
template <typename Record, size_t kCount>
void write_fields(CsvLine& line, const std::array<Field<Record>, kCount>& fields, CsvPlace place,
                  const Record& record, bool has_measures = true) {
  for (const Field<Record>& field : fields) {
    if (field.csv != place) continue;
    const auto write = [&](auto member) {
      using Value = std::remove_cvref_t<decltype(record.*member)>;
      constexpr bool is_measure = std::is_same_v<Value, double> || std::is_same_v<Value, Pose>;
      if (is_measure && !has_measures) {
        line.empty_fields(component_names(field, PoseAs::kQuaternion).size());
      } else {
        put(line, record.*member);
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

void write_condition(CsvLine& line, const Condition& condition, const std::set<std::string>& keys,
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

void write_sighting(CsvLine& line, const Sighting& sighting) {
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
void write_estimate(CsvLine& line, const TrialRecord& trial, const Counts& counts,
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
void write_orientation(CsvLine& line, const OrientationStudy& study, const TrialRecord& trial,
                       const OrientationRecord& orientation) {
  write_fields(line, kOrientationFields, CsvPlace::kSolver, orientation);
  write_fields(line, kOrientationFields, CsvPlace::kStatus, orientation);
  line << study.pairs.copies;
  write_fields(line, kOrientationFields, CsvPlace::kResult, orientation);
  write_fields(line, kTrialFields, CsvPlace::kPose, trial);
  write_fields(line, kOrientationFields, CsvPlace::kEnd, orientation);
}

void write_orientation_csv(const Study& study, const OrientationStudy& of_kind,
                           const TrialSource& trials, std::ostream& out) {
  const std::set<std::string> keys = condition_keys(study);
  out << header(orientation_columns(keys));
  trials([&](const TrialRecord& trial) {
    for (const OrientationRecord& orientation : trial.orientations()) {
      CsvLine line;
      write_condition(line, study.conditions[trial.condition], keys, trial);
      write_orientation(line, of_kind, trial, orientation);
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
  if (const OrientationStudy* const orientation = study.orientation()) {
    return write_orientation_csv(study, *orientation, trials, out);
  }
  const ImageStudy* const images = study.images();
  const bool is_sighted = images != nullptr && images->sighted;
  const std::set<std::string> keys = condition_keys(study);
  out << header(estimate_columns(keys, is_sighted));
  trials([&](const TrialRecord& trial) {
    const Counts counts = count_observations(trial);
    for (const EstimateRecord& estimate : trial.estimates()) {
      CsvLine line;
      write_condition(line, study.conditions[trial.condition], keys, trial);
      if (is_sighted) write_sighting(line, images->sighting_of(trial.trial));
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
      CsvLine line;
      write_condition(line, study.conditions[trial.condition], keys, trial);
      write_fields(line, kOrientationFields, CsvPlace::kSolver, orientation);
      write_fields(line, kOrientationFields, CsvPlace::kTiming, orientation);
      out << std::move(line).end();
    }
  });
}

}  // namespace sightline
