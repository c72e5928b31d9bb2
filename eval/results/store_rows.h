// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>

#include "eval/records/records.h"

namespace SQLite {
class Database;
}

namespace sightline {

// The rows of a store's tables, by eval/records/records.h. What SQLite refuses throws
// SQLite::Exception, a text that is no name UnknownName, and a list that is no JSON the exception
// of that library.

/// Adds trials, within the caller's transaction. Throws InputError of a trial that is there
/// already; `file` names the store in its text.
void write_trials(SQLite::Database& database, std::span<const TrialRecord> trials,
                  const std::string& file);

/// Hands out the trials by their numbers, never more than one in memory. A column that a table
/// lacks reads as NULL: NaN, zero, or no value. A row that belongs to no trial, a gap in a trial's
/// list and a value of another kind than its column's throw SQLite::Exception. The database must
/// outlive it.
NextTrial trial_reader(const SQLite::Database& database);

}  // namespace sightline
