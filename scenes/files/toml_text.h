// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// TOML as text, before it is read and after it is written (scenes/files/toml_table.h).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace sightline {

/// A text as TOML writes it, in quotes, whatever it holds.
std::string toml_text(std::string_view text);

/// What was typed as a value in TOML: as it is where it is one, else as a text in quotes. None for
/// what stands in brackets as a list or a table does and is none.
std::optional<std::string> typed_value(const std::string& typed);

/// A name made of any text: its letters, digits, '-' and '.', all else as underscores, which need
/// no escape in TOML or a shell. It is never empty and does not begin with a '.'.
std::string plain_name(std::string_view text);

/// TOML with its numbers in the fewest digits that read back the same: toml++ writes 0.15 as
/// 0.14999999999999999. Texts stay as they are.
std::string with_shortest_numbers(std::string_view toml);

/// Refuses, by an InputError with the line, dotted keys of very many parts: they make a table in a
/// table in a table, through which all that reads them calls itself.
void require_shallow_keys(std::string_view toml, const std::filesystem::path& name);

}  // namespace sightline
