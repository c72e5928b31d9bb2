// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/tables/labels.h"

#include "eval/output/text_table.h"

namespace sightline {

std::vector<std::string> condition_labels(const Study& study, size_t longest) {
  std::vector<std::string> labels;
  for (const Condition& c : study.conditions) labels.push_back(shortened(c.label, longest));
  return labels;
}

}  // namespace sightline
