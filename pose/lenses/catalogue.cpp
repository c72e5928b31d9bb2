// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/lenses/catalogue.h"

#include <algorithm>

namespace sightline {
namespace {

Lens brown_conrady_of(std::span<const double> k) {
  return BrownConrady{.k1 = k[0], .k2 = k[1], .p1 = k[2], .p2 = k[3], .k3 = k[4]};
}

std::vector<double> brown_conrady_numbers(const Lens& lens) {
  const auto& k = std::get<BrownConrady>(lens);
  return {k.k1, k.k2, k.p1, k.p2, k.k3};
}

Lens rational_of(std::span<const double> k) {
  return RationalLens{.k1 = k[0],
                      .k2 = k[1],
                      .p1 = k[2],
                      .p2 = k[3],
                      .k3 = k[4],
                      .k4 = k[5],
                      .k5 = k[6],
                      .k6 = k[7],
                      .s1 = k[8],
                      .s2 = k[9],
                      .s3 = k[10],
                      .s4 = k[11]};
}

std::vector<double> rational_numbers(const Lens& lens) {
  const auto& k = std::get<RationalLens>(lens);
  return {k.k1, k.k2, k.p1, k.p2, k.k3, k.k4, k.k5, k.k6, k.s1, k.s2, k.s3, k.s4};
}

Lens kannala_brandt_of(std::span<const double> k) {
  return KannalaBrandt{.k1 = k[0], .k2 = k[1], .k3 = k[2], .k4 = k[3]};
}

std::vector<double> kannala_brandt_numbers(const Lens& lens) {
  const auto& k = std::get<KannalaBrandt>(lens);
  return {k.k1, k.k2, k.k3, k.k4};
}

}  // namespace

std::span<const LensModel> lens_models() {
  static const std::vector<LensModel> models = {
      {.name = "brown_conrady",
       .title = "Brown and Conrady",
       .coefficients = {"k1", "k2", "p1", "p2", "k3"},
       .counts = {4, 5},
       .make = brown_conrady_of,
       .coefficients_of = brown_conrady_numbers},
      {.name = "rational",
       .title = "the rational model",
       .coefficients = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4"},
       .counts = {8, 12},
       .make = rational_of,
       .coefficients_of = rational_numbers},
      {.name = "fisheye",
       .title = "Kannala and Brandt",
       .coefficients = {"k1", "k2", "k3", "k4"},
       .counts = {4},
       .make = kannala_brandt_of,
       .coefficients_of = kannala_brandt_numbers}};
  return models;
}

const LensModel& model_of(const Lens& lens) {
  return lens_models()[lens.index()];
}

const LensModel* find_lens_model(std::string_view name) {
  const auto models = lens_models();
  const auto found = std::ranges::find(models, name, &LensModel::name);
  return found == models.end() ? nullptr : &*found;
}

std::vector<double> coefficients_of(const Lens& lens) {
  return model_of(lens).coefficients_of(lens);
}

std::optional<Lens> make_lens(const LensModel& model, std::span<const double> coefficients) {
  if (std::ranges::find(model.counts, coefficients.size()) == model.counts.end()) {
    return std::nullopt;
  }
  std::vector<double> all(coefficients.begin(), coefficients.end());
  all.resize(model.coefficients.size());
  return model.make(all);
}

}  // namespace sightline
