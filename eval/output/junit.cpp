// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/junit.h"

#include <algorithm>
#include <sstream>
#include <string_view>

#include <pugixml.hpp>

#include "eval/output/plain_text.h"

namespace sightline {
namespace {

// The length of what XML 1.0 cannot hold, not even escaped, at the start of a plain text: U+FFFE or
// U+FFFF; 0 where there is none.
size_t forbidden_length(std::string_view text) {
  return text.starts_with("\xEF\xBF\xBE") || text.starts_with("\xEF\xBF\xBF") ? 3 : 0;
}

std::string xml_text(std::string_view given) {
  constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD
  const std::string plain = plain_text(given);
  std::string_view text = plain;
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

void set_totals(pugi::xml_node node, const JunitSuite& suite) {
  const auto failures = std::count_if(suite.cases.begin(), suite.cases.end(),
                                      [](const JunitCase& c) { return !c.failure.empty(); });
  set_attribute(node, "tests", std::to_string(suite.cases.size()));
  set_attribute(node, "failures", std::to_string(failures));
}

void add_properties(pugi::xml_node node, const JunitSuite& suite) {
  if (suite.properties.empty()) return;
  pugi::xml_node properties = node.append_child("properties");
  for (const auto& [name, value] : suite.properties) {
    pugi::xml_node property = properties.append_child("property");
    set_attribute(property, "name", name);
    set_attribute(property, "value", value);
  }
}

void add_case(pugi::xml_node node, const JunitCase& one) {
  pugi::xml_node test_case = node.append_child("testcase");
  set_attribute(test_case, "classname", one.class_name);
  set_attribute(test_case, "name", one.name);
  if (!one.failure.empty()) {
    set_attribute(test_case.append_child("failure"), "message", one.failure);
  } else if (!one.note.empty()) {
    test_case.append_child("system-out").text().set(xml_text(one.note).c_str());
  }
}

}  // namespace

std::string to_xml(const JunitSuite& suite) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  set_attribute(declaration, "version", "1.0");
  set_attribute(declaration, "encoding", "UTF-8");
  pugi::xml_node suites = document.append_child("testsuites");
  set_totals(suites, suite);
  pugi::xml_node node = suites.append_child("testsuite");
  set_attribute(node, "name", suite.name);
  set_totals(node, suite);
  add_properties(node, suite);
  for (const JunitCase& one : suite.cases) add_case(node, one);
  std::ostringstream text;
  document.save(text, " ", pugi::format_default, pugi::encoding_utf8);
  return text.str();
}

}  // namespace sightline
