// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/records/records.h"

namespace sightline {

/// The trials of one run in one SQLite file (schema in docs/columns.md, its version in the file's
/// user_version). One writer a file; readers may look meanwhile. What is read back equals what was
/// added bit by bit (any NaN as the quiet NaN), so that joined shards equal one run. Throws
/// InputError when the file cannot be made, read or written.
class Store {
 public:
  /// Makes a new store; the file must not exist, its folder must. `meta` is kept as key and value
  /// (study, seed, version, shard...). A process that is killed meanwhile leaves no file of that
  /// name, so that a store which is there is one.
  static Store create(const std::filesystem::path& file,
                      const std::map<std::string, std::string>& meta);
  /// Opens a store that exists, to read it or to add to it; a write-protected file
  /// can be read. What a killed writer left half written is rolled back. Throws InputError for a
  /// file that is not a store. Of a store of an older schema, the columns that it lacks read as
  /// empty; to add to it gives it those columns.
  static Store open(const std::filesystem::path& file);

  Store(Store&&) noexcept;
  Store& operator=(Store&&) noexcept;
  ~Store();

  /// Adds trials in one transaction: all of them or, where it throws, none. A trial that the store
  /// holds already is an InputError.
  void add(std::span<const TrialRecord> trials);

  /// Adds all trials of another store, in one transaction. Quicker than to read and add them.
  void add_all_of(const std::filesystem::path& file);

  /// All trials, by their number.
  std::vector<TrialRecord> trials() const;
  /// The same one by one, never more than one in memory.
  void for_each(const TrialVisitor& visit) const;
  /// The same as they are asked for. The store must outlive it.
  NextTrial reader() const;
  /// How many there are.
  int64_t size() const;
  /// Whether the store holds each of the trials 0 to `end` - 1.
  std::vector<bool> held(int64_t end) const;
  /// The least number of a trial; none of an empty store.
  std::optional<int64_t> first_trial() const;
  bool holds(int64_t trial) const;
  std::map<std::string, std::string> meta() const;
  const std::filesystem::path& file() const;

 private:
  struct Impl;
  explicit Store(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sightline
