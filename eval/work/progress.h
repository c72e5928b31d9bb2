// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace sightline {

/// A progress bar on stderr with rate and time left; silent unless stderr is a terminal.
class Progress {
 public:
  Progress(std::string label, int64_t total, bool is_wanted);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(int64_t steps);

 private:
  void draw();

  std::string label_;
  int64_t total_;
  int64_t done_ = 0;
  bool is_shown_;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_draw_;
};

}  // namespace sightline
