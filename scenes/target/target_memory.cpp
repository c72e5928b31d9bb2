// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/target_memory.h"

#include <filesystem>

namespace sightline {
namespace {

thread_local TargetMemory* current_memory = nullptr;

}  // namespace

TargetMemory::TargetMemory() {
  if (current_memory == nullptr) current_memory = this;
}

TargetMemory::~TargetMemory() {
  if (current_memory == this) current_memory = nullptr;
}

std::shared_ptr<const Target> TargetMemory::get(const std::filesystem::path& file,
                                                const MeshUse& use, const Loader& load) {
  if (current_memory == nullptr) return load();
  // The name of a file is that of its target, also where it is a link.
  const std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  std::error_code error;
  const std::filesystem::path real = std::filesystem::weakly_canonical(folder, error);
  const Key key(((error ? folder : real) / file.filename()).string(), use);
  auto& known = current_memory->known_;
  const auto found = known.find(key);
  if (found != known.end()) return found->second;
  const std::shared_ptr<const Target> target = load();
  known.emplace(key, target);
  return target;
}

}  // namespace sightline
