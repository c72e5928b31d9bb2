// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/solve/camera_file.h"

#include "scenes/camera/calibration_file.h"
#include "scenes/files/toml_table.h"
#include "scenes/scene/imaging.h"

namespace sightline {
namespace {

Camera read_toml_camera(const std::filesystem::path& file) {
  const TomlTable table = TomlTable::read_file(file);
  if (!table.has("camera")) table.fail("camera", "is missing: the file must have such a table");
  return read_camera(table.table("camera"));
}

}  // namespace

Camera read_camera_file(const std::filesystem::path& file) {
  if (file.extension() == ".toml") return read_toml_camera(file);
  return read_calibration_file(file);
}

}  // namespace sightline
