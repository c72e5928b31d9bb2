// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/junit.h"

#include <sstream>
#include <string_view>

#include <pugixml.hpp>

#include "eval/compare/compare_text.h"

namespace sightline {
namespace {

// The length of what XML 1.0 cannot hold, not even escaped, at the start of a text in UTF-8: a
// control character, U+FFFE or U+FFFF; 0 where there is none.
size_t forbidden_length(std::string_view text) {
  const auto first = static_cast<unsigned char>(text.front());
  const bool is_space = first == '\t' || first == '\n' || first == '\r';
  if (first < 0x20 && !is_space) return 1;
  return text.starts_with("\xEF\xBF\xBE") || text.starts_with("\xEF\xBF\xBF") ? 3 : 0;
}

std::string xml_text(std::string_view text) {
  constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD
  std::string allowed;
  while (!text.empty()) {
    const size_t forbidden = forbidden_length(text);
    allowed += forbidden > 0 ? kReplacement : text.substr(0, 1);
    text.remove_prefix(forbidden > 0 ? forbidden : 1);
  }
  return allowed;
}

void set_attribute(pugi::xml_node node, const char* name, std::string_view value) {
  node.append_attribute(name).set_value(xml_text(value).c_str());
}

void set_totals(pugi::xml_node node, const Comparison& comparison) {
  const int64_t failures = comparison.count(Verdict::kWorse) + comparison.count(Verdict::kMissing);
  set_attribute(node, "tests", std::to_string(comparison.cells.size()));
  set_attribute(node, "failures", std::to_string(failures));
}

void add_case(pugi::xml_node suite, const std::string& study, const CellDifference& cell) {
  pugi::xml_node test_case = suite.append_child("testcase");
  set_attribute(test_case, "classname", study + "." + cell.condition);
  set_attribute(test_case, "name", cell.solver);
  const std::string changes = changes_text(cell);
  const bool is_failure = cell.verdict == Verdict::kWorse || cell.verdict == Verdict::kMissing;
  if (is_failure) {
    set_attribute(test_case.append_child("failure"), "message", changes);
  } else if (!changes.empty()) {
    test_case.append_child("system-out").text().set(xml_text(changes).c_str());
  }
}

}  // namespace

std::string to_junit(const Comparison& comparison) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  set_attribute(declaration, "version", "1.0");
  set_attribute(declaration, "encoding", "UTF-8");
  pugi::xml_node suites = document.append_child("testsuites");
  set_totals(suites, comparison);
  pugi::xml_node suite = suites.append_child("testsuite");
  set_attribute(suite, "name", comparison.study);
  set_totals(suite, comparison);
  for (const CellDifference& cell : comparison.cells) add_case(suite, comparison.study, cell);
  std::ostringstream text;
  document.save(text, " ", pugi::format_default, pugi::encoding_utf8);
  return text.str();
}

}  // namespace sightline
