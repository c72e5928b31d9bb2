// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// JUnit XML, in which CI systems show what passed and what failed.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sightline {

struct JunitCase {
  std::string class_name;
  std::string name;
  std::string failure;  ///< why it failed; empty of one that passed
  std::string note;     ///< of one that passed, if there is something to say
};

struct JunitSuite {
  std::string name;
  std::vector<std::pair<std::string, std::string>> properties;  ///< names and values
  std::vector<JunitCase> cases;
};

/// The file. Whatever the texts hold it is XML: what XML cannot hold becomes U+FFFD.
std::string to_xml(const JunitSuite& suite);

}  // namespace sightline
