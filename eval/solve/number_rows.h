// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace sightline {

/// The rows of a file of numbers as people have them: separated by commas, semicolons, tabs or
/// spaces; lines that begin with # and a first line of names do not count. Every row has between
/// `least` and `most` numbers, all the same count; "nan" is one. `what` says in words what a row
/// must hold. Throws InputError, with file and line, for whatever is not so.
std::vector<std::vector<double>> read_number_rows(const std::filesystem::path& file, size_t least,
                                                  size_t most, const std::string& what);

}  // namespace sightline
