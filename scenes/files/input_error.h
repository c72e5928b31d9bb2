// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace sightline {

/// Something the user gave cannot be used. what() is one line that says where (file, key or
/// option), what was given and what is allowed. Everything else that fails is a status value.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The candidate closest to a misspelt name, or empty if none is close (edit distance over a third
/// of the length).
std::string closest_name(std::string_view given, std::span<const std::string> candidates);

/// " (did you mean 'x'?)" or, where nothing is close, " (known: a, b, c)".
std::string suggestion(std::string_view given, std::span<const std::string> candidates);

}  // namespace sightline
