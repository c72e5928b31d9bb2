// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The wing corners of the ORPE paper (section 4): in the window, Canny edges; Hough lines; for each
// of the feature's two edges the line with the most votes within a tolerance of the direction that
// the prior pose predicts; a least-squares line through the edge pixels that agree with it; the
// feature is where the two lines meet.
// The paper does not say how it tells the two lines apart; the predicted directions do it here. The
// nearest wrong edge of like direction can win the vote (a trailing edge for a leading edge): that
// is the outlier the paper is about.
#include "features/extractors/extractors.h"
#include "features/hough_lines.h"
#include "features/image_line.h"

namespace sightline {

Observation extract_hough_intersection(const ExtractionInput& input) {
  const LineOptions& options = input.options.line;
  const HoughTransform hough = hough_transform(input.image, input.window, options);
  std::vector<ImageLine> lines;
  for (const Eigen::Vector2d& direction : input.prediction.edge_direction) {
    for (ImageLine& line : lines_along(direction, hough, input, options, 1)) {
      lines.push_back(std::move(line));
    }
  }
  return found_at_meeting(nothing_found(input), std::move(lines), options.min_angle_deg);
}

}  // namespace sightline
