// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/gltf_uri.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>

namespace sightline {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

// Where the string of a URI begins whose key ends at `at`; npos where no string follows.
size_t begin_of_uri(std::string_view text, size_t at) {
  at = text.find_first_not_of(kBlanks, at);
  if (at == text.npos || text[at] != ':') return text.npos;
  at = text.find_first_not_of(kBlanks, at + 1);
  return at == text.npos || text[at] != '"' ? text.npos : at + 1;
}

std::string escaped_text(std::string_view text) {
  constexpr std::string_view kKey = "\"uri\"";
  std::string out;
  size_t done = 0;
  for (size_t key = text.find(kKey); key != text.npos; key = text.find(kKey, key + 1)) {
    const size_t begin = begin_of_uri(text, key + kKey.size());
    if (begin == text.npos || text.substr(begin).starts_with("data:")) continue;
    const size_t end = std::min(text.find('"', begin), text.size());
    out += text.substr(done, begin - done);
    for (const char c : text.substr(begin, end - begin))
      out += c == '+' ? "%2B" : std::string(1, c);
    done = end;
  }
  return out += text.substr(done);
}

void put(std::string& bytes, size_t at, size_t number) {
  const auto value = static_cast<uint32_t>(number);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

}  // namespace

std::string path_of_uri(std::string_view uri) {
  std::string path;
  for (size_t i = 0; i < uri.size(); ++i) {
    int code = 0;
    const char* const digits = uri.data() + i + 1;
    const bool is_escape = uri[i] == '%' && i + 2 < uri.size() &&
                           std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2;
    path += is_escape ? static_cast<char>(code) : uri[i];
    if (is_escape) i += 2;
  }
  return path;
}

std::optional<std::string> with_escaped_pluses(std::string_view gltf) {
  constexpr size_t kHeaderBytes = 20;  // of the file 12, of its first chunk 8
  const bool is_binary = gltf.starts_with("glTF");
  if (is_binary && gltf.size() < kHeaderBytes) return std::nullopt;
  uint32_t length = 0;
  if (is_binary) std::memcpy(&length, gltf.data() + 12, sizeof length);
  const std::string_view text = is_binary ? gltf.substr(kHeaderBytes, length) : gltf;
  std::string escaped = escaped_text(text);
  if (escaped.size() == text.size()) return std::nullopt;
  if (!is_binary) return escaped;
  escaped.append((4 - escaped.size() % 4) % 4, ' ');  // chunks begin at multiples of four
  std::string out(gltf.substr(0, kHeaderBytes));
  put(out, 8, gltf.size() - text.size() + escaped.size());
  put(out, 12, escaped.size());
  out += escaped;
  return out += gltf.substr(kHeaderBytes + text.size());
}

}  // namespace sightline
