// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/tables/labels.h"

#include <cmath>

#include <fmt/format.h>

#include "eval/output/text_table.h"

namespace sightline {

std::vector<std::string> condition_labels(const Study& study, size_t longest) {
  std::vector<std::string> labels;
  for (const Condition& c : study.conditions) labels.push_back(shortened(c.label, longest));
  return labels;
}

std::string interval_text(const Interval95& ends, int decimals) {
  if (std::isnan(ends[0]) && std::isnan(ends[1])) return "-";
  return fmt::format("[{}, {}]", number_text(ends[0], decimals), number_text(ends[1], decimals));
}

}  // namespace sightline
