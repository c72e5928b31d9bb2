// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pose/lenses/lens.h"

namespace sightline {

/// A lens model as files name it.
struct LensModel {
  std::string name;
  std::string title;                      ///< whose it is
  std::vector<std::string> coefficients;  ///< their names, in the order of files
  std::vector<std::size_t> counts;        ///< how many of them may be given; the others are 0
  Lens (*make)(std::span<const double> all_coefficients);
  std::vector<double> (*coefficients_of)(const Lens& lens);
};

/// All models, in the order of `Lens`.
std::span<const LensModel> lens_models();

/// The model of a lens, and the model of that name; null where there is none.
const LensModel& model_of(const Lens& lens);
const LensModel* find_lens_model(std::string_view name);

/// The coefficients of a lens, in the order of its model.
std::vector<double> coefficients_of(const Lens& lens);

/// The lens with these coefficients; none where the model does not take so many.
std::optional<Lens> make_lens(const LensModel& model, std::span<const double> coefficients);

}  // namespace sightline
