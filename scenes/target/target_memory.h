// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "scenes/target/target.h"

namespace sightline {

/// While one lives, `load_target` reads each file once for this thread, and gives the same target
/// again for the same file and use: a command that looks at a mesh to make its scene, and then has
/// the scene read, reads millions of triangles once. What changes on the disk meanwhile is not
/// seen. Within another one's life it does nothing.
class TargetMemory {
 public:
  TargetMemory();
  ~TargetMemory();
  TargetMemory(const TargetMemory&) = delete;
  TargetMemory& operator=(const TargetMemory&) = delete;

 private:
  friend std::shared_ptr<const Target> load_target(const std::string&, const MeshUse&);
  using Loader = std::function<std::shared_ptr<const Target>()>;
  using Key = std::pair<std::string, MeshUse>;  // of the file's path

  // The target that this thread remembers, or that is loaded now.
  static std::shared_ptr<const Target> get(const std::filesystem::path& file, const MeshUse& use,
                                           const Loader& load);

  std::map<Key, std::shared_ptr<const Target>> known_;
};

}  // namespace sightline
