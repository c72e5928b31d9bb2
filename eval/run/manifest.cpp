// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/manifest.h"

#include <algorithm>
#include <chrono>
#include <fstream>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include "eval/output/json.h"
#include "eval/output/output_folder.h"
#include "eval/output/plain_text.h"
#include "scenes/mesh/mesh_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kManifestFile = "manifest.json";

std::string machine() {
  utsname system{};
  uname(&system);
  std::string processor = "unknown processor";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    processor = line.substr(std::min(line.size(), line.find(':') + 2));
    break;
  }
  return fmt::format("{} {}, {}", system.sysname, system.machine, processor);
}

}  // namespace

nlohmann::json manifest_of(const Study& study, const std::string& command) {
  return {{"version", SIGHTLINE_VERSION},
          {"study", study.name},
          {"seed", study.seed},
          {"trials", study.trial_count()},
          {"command", plain_line(command)},
          {"machine", machine()},
          {"started",
           fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::now()))}};
}

nlohmann::json read_manifest(const fs::path& run) {
  if (!is_inside(run, run / kManifestFile)) return nlohmann::json::value_t::discarded;
  try {
    return read_json(run / kManifestFile);
  } catch (const InputError&) {
    return nlohmann::json::value_t::discarded;
  }
}

void write_manifest(const nlohmann::json& manifest, const fs::path& run) {
  write_file(run / kManifestFile, manifest.dump(2) + "\n");
}

std::map<std::string, std::string> as_texts(const nlohmann::json& manifest) {
  std::map<std::string, std::string> texts;
  if (!manifest.is_object()) return texts;
  for (const auto& [key, value] : manifest.items()) {
    texts[key] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  return texts;
}

}  // namespace sightline
