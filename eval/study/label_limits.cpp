// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study/label_limits.h"

namespace sightline {

std::vector<Key> keys_of(LabelLimits& limits) {
  return {
      {"extraction",
       "outlier_px",
       &limits.outlier_px,
       {0.01, 1000},
       "px",
       "a feature found farther than this from the truth is an outlier"},
      {.table = "extraction",
       .name = "outlier_sigmas",
       .value = &limits.outlier_sigmas,
       .allowed = {0.1, 1e6},
       .unit = "sigma",
       .meaning = "and so is one farther in units of its own covariance",
       .if_absent = "none"},
      {"extraction",
       "line_px",
       &limits.line_px,
       {0.01, 1000},
       "px",
       "a line is wrong whose edge pixels have a larger RMS distance from the true edge"},
      {"extraction",
       "least_contrast_grey",
       &limits.least_contrast_grey,
       {0, 255},
       "grey level of 255",
       "a feature whose edges have less contrast in the image counts as not to be seen"},
  };
}

}  // namespace sightline
