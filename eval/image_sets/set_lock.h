// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "eval/work/shard.h"

namespace sightline {

/// Keeps two runs from doing the same images of a set: a run holds its shard for as long as the
/// process and its workers live, however they end. Shards of one division may run at once, on other
/// machines too where the file system locks across them; shards of two divisions may not.
class SetLock {
 public:
  /// Locks `folder`/.lock, which it makes if need be. Throws InputError when another run holds the
  /// shard or one of another division, and when the file cannot be written.
  SetLock(const std::filesystem::path& folder, const Shard& shard);
  ~SetLock();
  SetLock(const SetLock&) = delete;
  SetLock& operator=(const SetLock&) = delete;

  /// While this lives, no other run of the set has one: for what all of them write.
  class Alone {
   public:
    explicit Alone(const SetLock& lock);
    ~Alone();
    Alone(const Alone&) = delete;
    Alone& operator=(const Alone&) = delete;

   private:
    int file_;
  };

 private:
  int file_ = -1;
};

}  // namespace sightline
