// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/frame_svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "eval/output/base64.h"
#include "eval/output/html.h"
#include "eval/output/numbers.h"
#include "features/image_line.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

constexpr double kFoundRadiusPx = 3;
constexpr double kRemovedRadiusPx = 4.2;
constexpr double kTruthArmPx = 2;
constexpr double kCornerArmPx = 1.2;
constexpr double kNeighbourPx = 2.1;  // a pixel apart along an edge, up to two from edge to edge
constexpr double kStraightPx = 0.05;  // what a line through samples may pass them by
constexpr int kDecimals = 2;          // a hundredth of a pixel

// Hundredths without trailing zeros: most of a report's bytes are such numbers.
std::string px(double value) {
  std::string text = fmt::format("{:.{}f}", value, kDecimals);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

cv::Mat as_8_bit(const cv::Mat& image, int bits) {
  if (image.depth() == CV_8U) return image;
  cv::Mat grey;
  image.convertTo(grey, CV_8U, 255.0 / ((1 << bits) - 1));
  return grey;
}

constexpr int kMaxWholeSidePx = 256;     // an image up to this size is shown whole
constexpr int kMaxPictureSidePx = 1024;  // and a part up to this one as it is
constexpr double kMargin = 0.1;          // about what is of interest, of its size

cv::Rect part_to_show(const cv::Size& image, const cv::Rect& of_interest) {
  const cv::Rect whole({0, 0}, image);
  if (std::max(image.width, image.height) <= kMaxWholeSidePx || of_interest.empty()) return whole;
  const int margin =
      static_cast<int>(kMargin * std::max(of_interest.width, of_interest.height)) + 1;
  const cv::Point corner(margin, margin);
  return whole & cv::Rect(of_interest.tl() - corner, of_interest.br() + corner);
}

// A pixel is the mean of a block.
cv::Mat reduced(const cv::Mat& image, int reduction) {
  if (reduction == 1) return image;
  cv::Mat small;
  cv::resize(image, small, image.size() / reduction, 0, 0, cv::INTER_AREA);
  return small;
}

std::string png_data_url(const cv::Mat& image) {
  return "data:image/png;base64," + base64(png_bytes(image, PngEffort::kSmall));
}

// Blue, white and red of the same lightness at both ends, to be told apart by who sees no red too
// (after ColorBrewer's RdBu); blue, green, red as OpenCV has them.
cv::Vec3b residual_colour(float sds) {
  constexpr double kStepsASd = 2;
  const cv::Vec3d white(247, 247, 247), blue(172, 102, 33), red(43, 24, 178);
  if (std::isnan(sds)) return {128, 128, 128};
  const double step = std::round(kStepsASd * sds) / (kStepsASd * kMostResidualSds);
  const double part = std::clamp(step, -1.0, 1.0);
  const cv::Vec3d mixed = white + std::abs(part) * ((part < 0 ? blue : red) - white);
  return {cv::saturate_cast<uchar>(mixed[0]), cv::saturate_cast<uchar>(mixed[1]),
          cv::saturate_cast<uchar>(mixed[2])};
}

// A mark on a dark line, to be seen on white paint and on the night sky.
std::string mark(std::string_view layer, std::string_view path, std::string_view title) {
  return fmt::format(R"svg(<g class="layer-{0} {0}"><title>{2}</title>)svg"
                     R"svg(<path class="halo" d="{1}"/><path d="{1}"/></g>)svg",
                     layer, path, escape_html(title));
}

std::string circle(const Eigen::Vector2d& centre, double radius) {
  return fmt::format("M{0} {1}a{2} {2} 0 1 0 {3} 0a{2} {2} 0 1 0 -{3} 0", px(centre.x() - radius),
                     px(centre.y()), px(radius), px(2 * radius));
}

std::string stroke(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return fmt::format("M{} {}L{} {}", px(from.x()), px(from.y()), px(to.x()), px(to.y()));
}

std::string diagonal_cross(const Eigen::Vector2d& centre, double arm) {
  const Eigen::Vector2d down(arm, arm);
  const Eigen::Vector2d up(arm, -arm);
  return stroke(centre - down, centre + down) + stroke(centre - up, centre + up);
}

std::string upright_cross(const Eigen::Vector2d& centre, double arm) {
  const Eigen::Vector2d across(arm, 0);
  const Eigen::Vector2d along(0, arm);
  return stroke(centre - across, centre + across) + stroke(centre - along, centre + along);
}

// The part of a straight line inside a window (Liang and Barsky 1984).
std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> clipped(const ImageLine& line,
                                                                   const cv::Rect& window) {
  const Eigen::Vector2d low(window.x - 0.5, window.y - 0.5);
  const Eigen::Vector2d high = low + Eigen::Vector2d(window.width, window.height);
  double begin = -1e9;
  double end = 1e9;
  for (int axis = 0; axis < 2; ++axis) {
    const double slope = line.direction[axis];
    if (slope == 0) {
      if (line.point[axis] < low[axis] || line.point[axis] > high[axis]) return std::nullopt;
      continue;
    }
    const double a = (low[axis] - line.point[axis]) / slope;
    const double b = (high[axis] - line.point[axis]) / slope;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  if (begin >= end) return std::nullopt;
  return std::pair(Eigen::Vector2d(line.point + begin * line.direction),
                   Eigen::Vector2d(line.point + end * line.direction));
}

std::string window_mark(const cv::Rect& window) {
  return fmt::format(
      R"svg(<rect class="layer-windows windows" x="{}" y="{}" width="{}" height="{}"/>)svg",
      px(window.x - 0.5), px(window.y - 0.5), window.width, window.height);
}

// Dots of one path: strokes of no length with round caps.
std::string edge_pixel_marks(const Observation& observation) {
  std::string path;
  const auto add = [&path](const std::vector<Eigen::Vector2d>& pixels) {
    for (const Eigen::Vector2d& pixel : pixels) {
      path += fmt::format("M{} {}h0", px(pixel.x()), px(pixel.y()));
    }
  };
  for (const ImageLine& line : observation.lines) add(line.edge_pixels);
  add(observation.contour);
  if (path.empty()) return "";
  return fmt::format(R"svg(<path class="layer-edges edges" d="{}"/>)svg", path);
}

std::string corner_marks(const std::vector<Eigen::Vector2d>& corners) {
  std::string path;
  for (const Eigen::Vector2d& corner : corners) path += upright_cross(corner, kCornerArmPx);
  if (path.empty()) return "";
  return fmt::format(R"svg(<path class="layer-edges corners" d="{}"/>)svg", path);
}

// Takes the nearest to a point out of those that are left, unless it is no neighbour.
std::optional<cv::Point2f> take_neighbour(const cv::Point2f& point,
                                          std::vector<cv::Point2f>& left) {
  const auto distance_px = [&point](const cv::Point2f& other) { return cv::norm(other - point); };
  const auto nearest = std::min_element(
      left.begin(), left.end(),
      [&](const auto& a, const auto& b) { return distance_px(a) < distance_px(b); });
  if (nearest == left.end() || distance_px(*nearest) > kNeighbourPx) return std::nullopt;
  const cv::Point2f taken = *nearest;
  *nearest = left.back();
  left.pop_back();
  return taken;
}

// Lines through the samples of an outline, whatever their order: from a sample each way, from
// neighbour to neighbour.
std::string outline_strokes(const std::vector<Eigen::Vector2d>& samples) {
  std::vector<cv::Point2f> left;
  for (const Eigen::Vector2d& sample : samples) {
    left.emplace_back(static_cast<float>(sample.x()), static_cast<float>(sample.y()));
  }
  std::string path;
  while (!left.empty()) {
    std::vector<cv::Point2f> line = {left.back()};
    left.pop_back();
    for (int end = 0; end < 2; ++end) {
      std::reverse(line.begin(), line.end());
      while (const auto next = take_neighbour(line.back(), left)) line.push_back(*next);
    }
    std::vector<cv::Point2f> simple;
    cv::approxPolyDP(line, simple, kStraightPx, /*closed=*/false);
    if (simple.size() < 2) continue;
    for (size_t i = 0; i < simple.size(); ++i) {
      path += fmt::format("{}{} {}", i == 0 ? 'M' : 'L', px(simple[i].x), px(simple[i].y));
    }
  }
  return path;
}

std::string line_marks(const Observation& observation) {
  std::string path = outline_strokes(observation.laid_outline);
  for (const ImageLine& line : observation.lines) {
    const auto ends = clipped(line, observation.window);
    if (ends) path += stroke(ends->first, ends->second);
  }
  if (path.empty()) return "";
  return fmt::format(R"svg(<path class="layer-lines lines" d="{}"/>)svg", path);
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string removed_mark(const ObservationRecord& record,
                         const std::vector<std::string>& removers) {
  const Eigen::Vector2d slash(kRemovedRadiusPx, -kRemovedRadiusPx);
  const std::string path =
      circle(record.pixel, kRemovedRadiusPx) + stroke(record.pixel - slash, record.pixel + slash);
  return mark("removed", path, fmt::format("{}: removed by {}", record.feature, joined(removers)));
}

}  // namespace

FramePicture picture_of(const cv::Mat& image, int bits, const cv::Rect& of_interest) {
  FramePicture picture;
  picture.image = image.size();
  if (image.empty()) return picture;
  picture.pixels = part_to_show(image.size(), of_interest);
  const int side = std::max(picture.pixels.width, picture.pixels.height);
  picture.reduction = (side + kMaxPictureSidePx - 1) / kMaxPictureSidePx;
  // Whole blocks of pixels, so that coordinates stay exact.
  picture.pixels.width -= picture.pixels.width % picture.reduction;
  picture.pixels.height -= picture.pixels.height % picture.reduction;
  picture.png_url = png_data_url(reduced(as_8_bit(image(picture.pixels), bits), picture.reduction));
  return picture;
}

ResidualPicture residual_picture(const std::string& solver, const ModelImage& model) {
  cv::Mat grey, colours(model.residual_sds.size(), CV_8UC3);
  model.model_grey.convertTo(grey, CV_8U);
  for (int y = 0; y < colours.rows; ++y) {
    for (int x = 0; x < colours.cols; ++x) {
      colours.at<cv::Vec3b>(y, x) = residual_colour(model.residual_sds.at<float>(y, x));
    }
  }
  return {solver, png_data_url(grey), png_data_url(colours), model.box};
}

std::string feature_marks(const Observation& observation, const ObservationRecord& record,
                          const std::vector<std::string>& removers) {
  std::string svg;
  if (!observation.window.empty()) svg += window_mark(observation.window);
  svg += line_marks(observation);
  svg += edge_pixel_marks(observation);
  svg += corner_marks(observation.corners);
  if (record.is_visible) {
    svg += mark("truth", diagonal_cross(record.true_pixel, kTruthArmPx),
                record.feature + ": true position");
  }
  if (!record.is_found()) return svg;
  svg += mark(
      "found", circle(record.pixel, kFoundRadiusPx),
      fmt::format("{}: found, {} px from the truth", record.feature, measure(record.error_px)));
  if (!removers.empty()) svg += removed_mark(record, removers);
  return svg;
}

std::string observed_line_mark(const EdgeLine& found, const LineRecord& record,
                               const std::vector<std::string>& removers) {
  const ImageLine& line = found.line;
  if (line.edge_pixels.empty()) return "";
  const Stretch seen = seen_stretch(line);
  const std::string path =
      stroke(line.point + seen.from_px * line.direction, line.point + seen.to_px * line.direction);
  const std::string name = fmt::format("{}, edge {}", record.feature, record.edge);
  std::string svg =
      mark("lines", path,
           fmt::format("{}: {}, {} px and {} sigmas off", name, to_string(record.label),
                       measure(std::abs(record.offset_px)), measure(record.error_sigmas)));
  if (!removers.empty()) {
    svg += mark("removed", path, fmt::format("{}: removed by {}", name, joined(removers)));
  }
  return svg;
}

std::string outline_path(const Outline& outline) {
  std::string path;
  for (const std::vector<Eigen::Vector2d>& polygon : outline) {
    for (size_t i = 0; i < polygon.size(); ++i) {
      path += fmt::format("{}{} {}", i == 0 ? 'M' : 'L', px(polygon[i].x()), px(polygon[i].y()));
    }
    path += 'Z';
  }
  return path;
}

std::string view_box(const cv::Rect& pixels) {
  return fmt::format("{} {} {} {}", px(pixels.x - 0.5), px(pixels.y - 0.5), pixels.width,
                     pixels.height);
}

}  // namespace sightline
