// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace sightline {

// Numbers as pages and the terminal show them. A file that programs read holds other ones: the
// shortest that read back the same (csv.h).

/// Fixed point for pages, with a true minus sign; "–" for what is not a number, "∞" for infinity.
std::string fixed(double value, int decimals);

/// Fixed point for the terminal, zero without a sign; "-" for what is not finite.
std::string number_text(double value, int decimals);

/// Decimals that show a measure to about its interval's width: two, more below 0.1, none from 100.
int decimals_for(double value);
std::string measure(double value);

/// "[1.20, 1.42]", from the texts of both ends.
std::string bracketed(std::string_view low, std::string_view high);

/// An interval for pages, "[1.20, 1.42]", with the decimals of the value that it belongs to; empty
/// where there is none (NaN).
std::string interval(const std::array<double, 2>& bounds, int decimals);

/// The same for the terminal; "-" where there is none.
std::string interval_text(const std::array<double, 2>& bounds, int decimals);

/// The number that is the whole text, which may begin with a plus and be nan or infinite, and is 0
/// where a double has none so small; none where it is no number, or too large.
std::optional<double> parsed_number(std::string_view text);

/// "12 (3.0 %)"; "0" alone for none of some, "–" for none of none.
std::string count_of(int64_t part, int64_t whole);

/// "1 trial", "400 trials".
std::string counted(int64_t count, std::string_view noun);

/// "(−20, 30, 40)".
std::string triple(const Eigen::Vector3d& values, int decimals);

/// The pitch, yaw and roll of a rotation in degrees.
Eigen::Vector3d attitude_deg(const Eigen::Matrix3d& rotation);

}  // namespace sightline
