// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/benchmarks/ratios.h"

#include <algorithm>
#include <iomanip>
#include <optional>
#include <set>
#include <sstream>

namespace sightline {
namespace {

using Times = std::map<std::string, double>;

constexpr int kWidth = 12;

std::string prefix_of(const std::string& family, const std::string& method) {
  return method.empty() ? family + "/" : family + "/" + method + "/";
}

std::optional<double> time_ns(const Times& best_ns, const std::string& family,
                              const std::string& method, int size) {
  const auto found = best_ns.find(prefix_of(family, method) + std::to_string(size));
  if (found == best_ns.end()) return std::nullopt;
  return found->second;
}

std::set<int> sizes_of(const Times& best_ns, const PeerComparison& comparison) {
  const std::string prefix = prefix_of(comparison.family, comparison.ours);
  std::set<int> sizes;
  for (const auto& [name, ns] : best_ns) {
    if (!name.starts_with(prefix)) continue;
    const std::string size = name.substr(prefix.size());
    if (size.find('/') == std::string::npos) sizes.insert(std::stoi(size));
  }
  return sizes;
}

int width_of(const std::string& method) {
  return std::max(kWidth, static_cast<int>(method.size()) + 2);
}

std::string row(const Times& best_ns, const PeerComparison& comparison, int size) {
  const double ours_ns = *time_ns(best_ns, comparison.family, comparison.ours, size);
  std::ostringstream line;
  line << std::fixed << std::setw(kWidth) << size << std::setprecision(ours_ns < 1e3 ? 1 : 0)
       << std::setw(width_of(comparison.ours)) << ours_ns;
  for (const std::string& peer : comparison.peers) {
    const int width = width_of(peer);
    const auto peer_ns = time_ns(best_ns, comparison.family, peer, size);
    if (!peer_ns) {
      line << std::setw(width + kWidth) << "";
      continue;
    }
    line << std::setprecision(0) << std::setw(width) << *peer_ns << std::setprecision(1)
         << std::setw(kWidth - 1) << *peer_ns / ours_ns << "x";
  }
  return line.str();
}

std::string heading(const PeerComparison& comparison) {
  std::ostringstream line;
  line << comparison.family << ", CPU time / ns of the fastest repetition, and times ours\n"
       << std::setw(kWidth) << "size" << std::setw(width_of(comparison.ours))
       << (comparison.ours.empty() ? "ours" : comparison.ours);
  for (const std::string& peer : comparison.peers) {
    const int width = width_of(peer);
    line << std::setw(width) << peer << std::setw(kWidth) << "";
  }
  return line.str();
}

}  // namespace

void RememberingReporter::ReportRuns(const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    if (run.error_occurred || run.run_type != Run::RT_Iteration) continue;
    const double ns = run.cpu_accumulated_time / static_cast<double>(run.iterations) * 1e9;
    const auto [best, is_new] = best_ns_.emplace(run.run_name.function_name, ns);
    if (!is_new) best->second = std::min(best->second, ns);
  }
  ConsoleReporter::ReportRuns(runs);
}

std::string ratio_tables(const std::vector<PeerComparison>& comparisons, const Times& best_ns) {
  std::ostringstream text;
  for (const PeerComparison& comparison : comparisons) {
    const std::set<int> sizes = sizes_of(best_ns, comparison);
    if (sizes.empty()) continue;
    text << '\n' << heading(comparison) << '\n';
    for (const int size : sizes) text << row(best_ns, comparison, size) << '\n';
  }
  return text.str();
}

}  // namespace sightline
