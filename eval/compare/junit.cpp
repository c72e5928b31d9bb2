// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/junit.h"

#include "eval/compare/compare_text.h"
#include "eval/output/junit.h"

namespace sightline {

std::string to_junit(const Comparison& comparison) {
  JunitSuite suite;
  suite.name = comparison.study;
  suite.properties = {{"compared", comparison.how}, {"settings", comparison.settings}};
  for (const CellDifference& cell : comparison.cells) {
    const std::string changes = changes_text(cell);
    const bool is_failure = cell.verdict == Verdict::kWorse || cell.verdict == Verdict::kMissing;
    suite.cases.push_back({.class_name = comparison.study + "." + cell.condition,
                           .name = cell.solver,
                           .failure = is_failure ? changes : "",
                           .note = is_failure ? "" : changes});
  }
  return to_xml(suite);
}

}  // namespace sightline
