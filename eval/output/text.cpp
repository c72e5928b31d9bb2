// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/text.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "pose/attitude.h"

namespace sightline {
namespace {

constexpr std::string_view kMinus = "−";

}  // namespace

std::string escape_html(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string script_json(std::string json) {
  for (size_t at = json.find('<'); at != std::string::npos; at = json.find('<', at)) {
    json.replace(at, 1, "\\u003c");
  }
  return json;
}

std::string fixed(double value, int decimals) {
  if (std::isnan(value)) return "–";
  const std::string digits =
      std::isinf(value) ? "∞" : fmt::format("{:.{}f}", std::abs(value), decimals);
  const bool is_zero = digits.find_first_not_of("0.") == std::string::npos;
  return value < 0 && !is_zero ? std::string(kMinus) + digits : digits;
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

std::string interval(const std::array<double, 2>& bounds, int decimals) {
  if (std::isnan(bounds[0]) && std::isnan(bounds[1])) return "";
  return fmt::format("[{}, {}]", fixed(bounds[0], decimals), fixed(bounds[1], decimals));
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

std::string solver_label(std::string_view name) {
  static const std::map<std::string, std::string, std::less<>> kSpelt = {
      {"gnc", "GNC"},   {"huber", "Huber"}, {"lspe", "LSPE"},     {"opencv", "OpenCV"},
      {"orpe", "ORPE"}, {"p3p", "P3P"},     {"ransac", "RANSAC"}, {"tukey", "Tukey"}};
  std::string label;
  for (size_t begin = 0; begin < name.size();) {
    const size_t end = std::min(name.find('_', begin), name.size());
    const std::string_view word = name.substr(begin, end - begin);
    const auto spelt = kSpelt.find(word);
    if (!label.empty()) label += ' ';
    label += spelt != kSpelt.end() ? spelt->second : std::string(word);
    begin = end + 1;
  }
  return label;
}

std::string words(std::string_view status) {
  std::string text(status);
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

}  // namespace sightline
