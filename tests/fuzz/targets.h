// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace sightline {

// What libFuzzer throws bytes at, one function a reader of ours: bad bytes must end in an exception
// that the program turns into one line, and what is accepted must hold together. A target aborts
// when that fails. To add one: declare it here, define it in targets.cpp, give it a line in
// CMakeLists.txt and a folder in corpus/.

/// The message a mesh reader's process sends, and the cleaning of its mesh.
void fuzz_soup(std::string_view bytes);

/// A .glb or .gltf, as its reader's process reads it.
void fuzz_gltf(std::string_view bytes);

/// A TOML file, through every getter.
void fuzz_toml(std::string_view bytes);

/// A PNG, JPEG or TIFF, as stored and as grey.
void fuzz_picture(std::string_view bytes);

/// A panorama, OpenEXR's or Radiance's.
void fuzz_radiance(std::string_view bytes);

/// A JSON file of a data set or a run, through every getter.
void fuzz_json(std::string_view bytes);

/// A CSV file, through every getter.
void fuzz_csv(std::string_view bytes);

/// A PLY model of a data set, every vertex kept.
void fuzz_model(std::string_view bytes);

/// What a process of somebody's answers: numbers, vectors and matrices.
void fuzz_answer(std::string_view bytes);

}  // namespace sightline
