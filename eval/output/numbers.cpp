// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/numbers.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <system_error>

#include <fmt/format.h>

#include "pose/attitude.h"

namespace sightline {
namespace {

constexpr std::string_view kMinus = "−";

}  // namespace

std::string fixed(double value, int decimals) {
  if (std::isnan(value)) return "–";
  const std::string digits =
      std::isinf(value) ? "∞" : fmt::format("{:.{}f}", std::abs(value), decimals);
  const bool is_zero = digits.find_first_not_of("0.") == std::string::npos;
  return value < 0 && !is_zero ? std::string(kMinus) + digits : digits;
}

std::string number_text(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  const std::string text = fmt::format("{:.{}f}", value, decimals);
  const bool is_zero = text.find_first_of("123456789") == std::string::npos;
  return is_zero && text.front() == '-' ? text.substr(1) : text;
}

int decimals_for(double value) {
  const double size = std::abs(value);
  if (!std::isfinite(size) || size == 0) return 2;
  if (size >= 100) return 0;
  if (size >= 0.1) return 2;
  return std::min(6, 1 - static_cast<int>(std::floor(std::log10(size))));
}

std::string measure(double value) {
  return fixed(value, decimals_for(value));
}

std::string bracketed(std::string_view low, std::string_view high) {
  return fmt::format("[{}, {}]", low, high);
}

std::string interval(const std::array<double, 2>& bounds, int decimals) {
  if (std::isnan(bounds[0]) && std::isnan(bounds[1])) return "";
  return bracketed(fixed(bounds[0], decimals), fixed(bounds[1], decimals));
}

std::string interval_text(const std::array<double, 2>& bounds, int decimals) {
  if (std::isnan(bounds[0]) && std::isnan(bounds[1])) return "-";
  return bracketed(number_text(bounds[0], decimals), number_text(bounds[1], decimals));
}

std::optional<double> parsed_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const char* const end = text.data() + text.size();
  double value = 0;
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (rest != end) return std::nullopt;
  if (error == std::errc()) return value;
  // Too large or too small: a type of more exponents knows which.
  long double wide = 0;
  const bool is_wide = std::from_chars(text.data(), end, wide).ec == std::errc();
  return is_wide && std::abs(wide) < 1 ? std::optional(0.0) : std::nullopt;
}

std::string count_of(int64_t part, int64_t whole) {
  if (whole == 0) return "–";
  if (part == 0) return "0";
  const double percent = 100.0 * static_cast<double>(part) / static_cast<double>(whole);
  return fmt::format("{} ({} %)", part, fixed(percent, 1));
}

std::string counted(int64_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string triple(const Eigen::Vector3d& values, int decimals) {
  return fmt::format("({}, {}, {})", fixed(values.x(), decimals), fixed(values.y(), decimals),
                     fixed(values.z(), decimals));
}

Eigen::Vector3d attitude_deg(const Eigen::Matrix3d& rotation) {
  const Attitude theta = attitude_from_rotation(rotation);
  return Eigen::Vector3d(theta.pitch_rad, theta.yaw_rad, theta.roll_rad) * (180 / std::numbers::pi);
}

}  // namespace sightline
