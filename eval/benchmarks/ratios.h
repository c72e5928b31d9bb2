// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

namespace sightline {

/// What is compared with what in benchmarks named `<family>/<method>/<size>`; a family whose own
/// method has no name calls it `<family>/<size>`.
struct PeerComparison {
  std::string family;
  std::string ours;                ///< the method that the peers are measured against
  std::vector<std::string> peers;  ///< methods of other libraries
};

/// Prints as Google Benchmark does, and remembers the fastest repetition of each benchmark, in CPU
/// time.
class RememberingReporter : public benchmark::ConsoleReporter {
 public:
  /// Colours are for terminals.
  explicit RememberingReporter(bool is_terminal)
      : ConsoleReporter(is_terminal ? OO_ColorTabular : OO_Tabular) {}

  void ReportRuns(const std::vector<Run>& runs) override;

  const std::map<std::string, double>& best_ns() const { return best_ns_; }

 private:
  std::map<std::string, double> best_ns_;
};

/// A table for each comparison: a row a size, our time, each peer's time and how many times ours it
/// is. What was not run is left out.
std::string ratio_tables(const std::vector<PeerComparison>& comparisons,
                         const std::map<std::string, double>& best_ns);

}  // namespace sightline
