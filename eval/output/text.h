// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace sightline {

/// Text as it may stand between tags and in quoted attributes.
std::string escape_html(std::string_view text);

/// JSON as it may stand in a <script> element: no "<", which might end it.
std::string script_json(std::string json);

/// Fixed point with a true minus sign; "–" for what is not a number, "∞" for infinity.
std::string fixed(double value, int decimals);

/// Decimals that show a measure to about its interval's width: two, more below 0.1, none from 100.
int decimals_for(double value);
std::string measure(double value);

/// "[1.20, 1.42]", with the decimals of the value that it belongs to; empty where there is none
/// (NaN).
std::string interval(const std::array<double, 2>& bounds, int decimals);

/// "12 (3.0 %)"; "0" alone for none of some, "–" for none of none.
std::string count_of(int64_t part, int64_t whole);

/// "1 trial", "400 trials".
std::string counted(int64_t count, std::string_view noun);

/// "(−20, 30, 40)".
std::string triple(const Eigen::Vector3d& values, int decimals);

/// The pitch, yaw and roll of a rotation in degrees.
Eigen::Vector3d attitude_deg(const Eigen::Matrix3d& rotation);

/// A solver's name for readers, as words: "orpe_tree" becomes "ORPE tree".
std::string solver_label(std::string_view name);

/// A status as words: "too_few_points" becomes "too few points".
std::string words(std::string_view status);

}  // namespace sightline
