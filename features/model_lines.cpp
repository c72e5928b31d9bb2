// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/model_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "features/blurred_edge.h"
#include "features/image_line.h"
#include "features/outline_search.h"

namespace sightline {
namespace {

constexpr double kGapPx = 2.5;  // kept off an edge's ends, where the next edge bends the gradient
constexpr double kMinSupport = 0.4;  // of the samples must have a peak on the line
constexpr size_t kFewestSamples = 4;
constexpr std::array kRoundsPx = {1.8, 1.3, 1.0, 0.8};  // of a peak from the line, round by round
// Neighbouring samples share what smoothing and blur spread: so many are worth one.
constexpr double kSamplesOfOne = 3;
constexpr double kLeastScatterPx = 0.05;
constexpr double kOtherPartPx = 0.8;  // more sigma for an edge against another part of the target

constexpr size_t kMostEdges = 5;       // of a feature: all combinations of their lines are tried
constexpr int kMostLines = 3;          // that an edge may have
constexpr double kMostSquares = 9;     // of lines that agree on a point
constexpr double kSlackPx2 = 0.25;     // of lines that are to agree
constexpr size_t kMostAgreements = 4;  // that are looked at
constexpr double kFarReachPx = 80;     // of what is fitted to the grey levels
constexpr size_t kEnoughSamples = 15;  // with fewer, an edge is looked at farther away

struct SamplePeaks {
  double along_px;
  EdgePeaks peaks;
};

// offset + slope (along - pivot), against the prediction.
struct Line {
  double offset_px = 0;
  double slope = 0;
};

std::vector<OutlineSample> samples_of(const PredictedEdge& edge) {
  std::vector<OutlineSample> samples;
  samples.reserve(edge.samples.size());
  for (const PredictedEdge::Sample& sample : edge.samples) {
    samples.push_back(
        {edge.begin + sample.along_px * edge.direction + sample.offset_px * edge.normal,
         edge.normal, sample.borders_target});
  }
  return samples;
}

// The line with the most votes, counted in cells of half a pixel and their neighbours.
Line voted(const std::vector<SamplePeaks>& samples, double pivot_px, double half_px,
           double max_slope) {
  constexpr double kCellPx = 0.5;
  constexpr int kSlopes = 6;  // to either side
  const int half_cells = static_cast<int>(std::ceil(half_px / kCellPx)) + 1;
  const int cells = 2 * half_cells + 1;
  std::vector<float> votes(cells);
  Line best;
  float most = 0;
  for (int i = -kSlopes; i <= kSlopes; ++i) {
    const double slope = max_slope * i / kSlopes;
    std::fill(votes.begin(), votes.end(), 0.F);
    for (const SamplePeaks& sample : samples) {
      for (const EdgePeak& peak : sample.peaks) {
        const double offset_px = peak.offset_px - slope * (sample.along_px - pivot_px);
        const int cell = half_cells + static_cast<int>(std::lround(offset_px / kCellPx));
        if (cell >= 0 && cell < cells) votes[cell] += 1;
      }
    }
    for (int cell = 1; cell + 1 < cells; ++cell) {
      // Of equal counts the better centred, then the lesser slope.
      const float count = votes[cell - 1] + 1.01F * votes[cell] + votes[cell + 1] -
                          1e-3F * static_cast<float>(std::abs(i));
      if (count <= most) continue;
      most = count;
      best = {(cell - half_cells) * kCellPx, slope};
    }
  }
  return best;
}

struct FittedLine {
  Line line;
  double rms_px = 0;
  Eigen::Matrix2d covariance;
  std::vector<std::pair<double, double>> points;  // along, offset
  double gradient = 0;                            // mean height of the peaks
};

std::optional<FittedLine> fitted(const std::vector<SamplePeaks>& samples, double pivot_px,
                                 Line line, double max_slope) {
  FittedLine fit;
  const double slope_sd = max_slope / 2;
  for (const double round_px : kRoundsPx) {
    fit.points.clear();
    fit.gradient = 0;
    double n = 0, st = 0, stt = 0, so = 0, sto = 0;
    for (const SamplePeaks& sample : samples) {
      const double t = sample.along_px - pivot_px;
      const double expected_px = line.offset_px + line.slope * t;
      const EdgePeak* nearest = nullptr;
      double nearest_px = round_px;
      for (const EdgePeak& peak : sample.peaks) {
        const double distance_px = std::abs(peak.offset_px - expected_px);
        if (distance_px > nearest_px) continue;
        nearest_px = distance_px;
        nearest = &peak;
      }
      if (nearest == nullptr) continue;
      fit.points.emplace_back(t, nearest->offset_px);
      fit.gradient += std::abs(nearest->gradient);
      n += 1;
      st += t;
      stt += t * t;
      so += nearest->offset_px;
      sto += t * nearest->offset_px;
    }
    if (n < kFewestSamples || n < kMinSupport * static_cast<double>(samples.size())) {
      return std::nullopt;
    }
    // The slope is known beforehand to slope_sd; a point to about a fifth of a pixel, three of them
    // worth one.
    constexpr double kPointPx = 0.2;
    const double known = kSamplesOfOne * kPointPx * kPointPx / (slope_sd * slope_sd);
    const double determinant = n * (stt + known) - st * st;
    line.slope = (n * sto - st * so) / determinant;
    line.offset_px = (so - line.slope * st) / n;
    fit.line = line;
    fit.covariance << (stt + known) / determinant, -st / determinant, -st / determinant,
        n / determinant;
  }
  double squares = 0;
  for (const auto& [t, offset_px] : fit.points) {
    const double residual = offset_px - line.offset_px - line.slope * t;
    squares += residual * residual;
  }
  const double n = static_cast<double>(fit.points.size());
  fit.gradient /= n;
  fit.rms_px = std::sqrt(squares / n);
  const double sd = std::max(fit.rms_px, kLeastScatterPx);
  fit.covariance *= kSamplesOfOne * sd * sd;
  if (std::abs(line.slope) > 1.5 * max_slope) return std::nullopt;
  return fit;
}

// What the fit does not know of, measured on airliners under many lights. Shading across a rounded
// edge moves its image: inwards and by more the darker its limb, against a darker background; less
// against a brighter one.
double floor_px(bool is_soft, double contrast_grey, int polarity) {
  constexpr double kMostPx = 1.5;
  if (!is_soft) return std::min(kMostPx, std::hypot(0.012, 1.7 / contrast_grey));
  const double against_bright = 2.4 / std::sqrt(contrast_grey);
  const double against_dark = 170 / std::pow(contrast_grey, 1.5);
  if (polarity > 0) return std::min(kMostPx, against_bright);
  return std::min(kMostPx, against_dark);
}

// True where mostly another part of the target is behind the outline, whose own edges are near.
bool borders_other_part(const PredictedEdge& edge) {
  const auto bordering = std::count_if(edge.samples.begin(), edge.samples.end(),
                                       [](const auto& sample) { return sample.borders_target; });
  return !edge.is_crease && 2 * bordering > static_cast<std::ptrdiff_t>(edge.samples.size());
}

double floor_px(const ExtractionInput& input, const PredictedEdge& edge, double contrast_grey,
                int polarity) {
  return input.options.search.floor_scale * floor_px(edge.is_soft, contrast_grey, polarity) +
         (borders_other_part(edge) ? kOtherPartPx : 0);
}

ImageLine image_line(const ExtractionInput& input, const PredictedEdge& edge, const FittedLine& fit,
                     double pivot_px, int polarity) {
  ImageLine line;
  line.point = edge.begin + pivot_px * edge.direction + fit.line.offset_px * edge.normal;
  line.direction = (edge.direction + fit.line.slope * edge.normal).normalized();
  line.rms_px = fit.rms_px;
  line.contrast_grey = fit.gradient / kGradientOfUnitEdge;
  line.covariance = fit.covariance;
  const double floor = floor_px(input, edge, line.contrast_grey, polarity);
  line.covariance(0, 0) += floor * floor;
  // ImageLine counts offsets along its direction turned by a right angle.
  const bool is_turned =
      edge.normal.dot(Eigen::Vector2d(-edge.direction.y(), edge.direction.x())) < 0;
  if (is_turned) line.covariance(0, 1) = line.covariance(1, 0) = -line.covariance(0, 1);
  for (const auto& [t, offset_px] : fit.points) {
    line.edge_pixels.push_back(edge.begin + (pivot_px + t) * edge.direction +
                               offset_px * edge.normal);
  }
  return line;
}

// Leaves the peaks that are not on a line.
void take_away(const Line& line, double pivot_px, std::vector<SamplePeaks>& samples) {
  constexpr double kOnLinePx = 1.5;
  for (SamplePeaks& sample : samples) {
    EdgePeaks left;
    for (const EdgePeak& peak : sample.peaks) {
      const double expected_px = line.offset_px + line.slope * (sample.along_px - pivot_px);
      if (std::abs(peak.offset_px - expected_px) > kOnLinePx) left.add(peak);
    }
    sample.peaks = left;
  }
}

// An edge as predicted, and where its samples are.
struct SearchedEdge {
  int index;
  PredictedEdge edge;
  std::vector<OutlineSample> samples;
};

// The feature's edges of which enough is to be seen; of many the longest seen.
std::vector<SearchedEdge> searched_edges(const ExtractionInput& input) {
  const SearchOptions& options = input.options.search;
  const double reach_px = is_prior_good(input) ? options.good_reach_px : options.reach_px;
  std::vector<SearchedEdge> edges;
  if (input.view.target == nullptr) return edges;
  const auto& own = input.view.target->features[input.prediction.feature].edges;
  for (int i = 0; i < static_cast<int>(own.size()); ++i) {
    PredictedEdge edge = predict_edge(input.view, input.prediction, i, {kGapPx, reach_px});
    if (!edge.is_soft && edge.samples.size() < kEnoughSamples) {
      // Edges that part at a small angle blur into one as far as that.
      edge = predict_edge(input.view, input.prediction, i, {kGapPx, kFarReachPx});
    }
    if (edge.samples.size() < kFewestSamples) continue;
    std::vector<OutlineSample> samples = samples_of(edge);
    edges.push_back({i, std::move(edge), std::move(samples)});
  }
  if (edges.size() <= kMostEdges) return edges;
  std::stable_sort(edges.begin(), edges.end(), [](const SearchedEdge& a, const SearchedEdge& b) {
    return a.samples.size() > b.samples.size();
  });
  edges.erase(edges.begin() + kMostEdges, edges.end());
  return edges;
}

// The lines along a predicted edge, best first.
std::vector<FoundLine> find_lines(const ExtractionInput& input, const GradientWindow& gradients,
                                  const SearchedEdge& searched, int polarity) {
  const SearchOptions& options = input.options.search;
  const PredictedEdge& edge = searched.edge;
  const double half_px = search_half_px(input, edge.normal);
  const double threshold = gradient_threshold(options);
  std::vector<SamplePeaks> peaks;
  peaks.reserve(searched.samples.size());
  for (size_t i = 0; i < searched.samples.size(); ++i) {
    const OutlineSample& sample = searched.samples[i];
    peaks.push_back(
        {edge.samples[i].along_px, find_peaks(gradients, sample.pixel, edge.normal, half_px,
                                              sample.borders_target ? 0 : polarity, threshold)});
  }
  const double pivot_px = (edge.samples.front().along_px + edge.samples.back().along_px) / 2;
  const double max_slope = is_prior_good(input) ? options.good_max_slope : options.max_slope;
  std::vector<FoundLine> lines;
  for (int i = 0; i < kMostLines; ++i) {
    const Line start = voted(peaks, pivot_px, half_px, max_slope);
    const auto fit = fitted(peaks, pivot_px, start, max_slope);
    if (!fit) break;
    const double support =
        static_cast<double>(fit->points.size()) / static_cast<double>(peaks.size());
    lines.push_back({searched.index, support, image_line(input, edge, *fit, pivot_px, polarity)});
    take_away(fit->line, pivot_px, peaks);
  }
  return lines;
}

// Without the evidence, and with what lines near a corner that is not yet known may err.
std::vector<std::vector<ImageLine>> with_slack(
    const std::vector<std::vector<FoundLine>>& lines_of) {
  std::vector<std::vector<ImageLine>> slack;
  for (const auto& candidates : lines_of) {
    slack.emplace_back();
    for (const FoundLine& found : candidates) {
      ImageLine line;
      line.point = found.line.point;
      line.direction = found.line.direction;
      line.covariance = found.line.covariance;
      line.covariance(0, 0) += kSlackPx2;
      slack.back().push_back(std::move(line));
    }
  }
  return slack;
}

// All ways in which two or more lines agree on a point in the window, best first, of those on
// nearly the same point only the best.
std::vector<Agreement> agreements(const ExtractionInput& input,
                                  const std::vector<std::vector<FoundLine>>& lines_of,
                                  const cv::Rect& window) {
  constexpr double kPriorWeight = 0.03;
  constexpr double kSamePx = 1;
  const Eigen::Matrix2d prior_information =
      (input.prediction.covariance_px2 + kSlackPx2 * Eigen::Matrix2d::Identity()).inverse();
  const std::vector<std::vector<ImageLine>> slack_lines = with_slack(lines_of);
  size_t combinations = 1;
  for (const auto& candidates : lines_of) combinations *= candidates.size() + 1;
  struct Choice {
    size_t combination;
    Eigen::Vector2d pixel;
    double value;
  };
  std::vector<Choice> choices;
  std::vector<ImageLine> lines;
  for (size_t combination = 1; combination < combinations; ++combination) {
    lines.clear();
    double value = 0;
    size_t rest = combination;
    for (size_t edge = 0; edge < lines_of.size(); ++edge) {
      const size_t choice = rest % (lines_of[edge].size() + 1);
      rest /= lines_of[edge].size() + 1;
      if (choice == 0) continue;
      lines.push_back(slack_lines[edge][choice - 1]);
      value += lines_of[edge][choice - 1].support;
    }
    if (lines.size() < 2) continue;
    const auto meeting = meeting_of(lines, kLeastMeetingDeg);
    if (!meeting || meeting->squares > kMostSquares || !contains(window, meeting->pixel)) continue;
    const Eigen::Vector2d off = meeting->pixel - input.prediction.pixel;
    value -= kPriorWeight * off.dot(prior_information * off);
    choices.push_back({combination, meeting->pixel, value});
  }
  std::stable_sort(choices.begin(), choices.end(),
                   [](const Choice& a, const Choice& b) { return a.value > b.value; });
  std::vector<Agreement> found;
  for (const Choice& choice : choices) {
    const bool is_known = std::any_of(found.begin(), found.end(), [&](const Agreement& other) {
      return (other.pixel - choice.pixel).norm() < kSamePx;
    });
    if (is_known) continue;
    Agreement agreement{{}, choice.pixel, choice.value};
    size_t rest = choice.combination;
    for (const auto& candidates : lines_of) {
      const size_t line = rest % (candidates.size() + 1);
      rest /= candidates.size() + 1;
      if (line > 0) agreement.lines.push_back(candidates[line - 1]);
    }
    found.push_back(std::move(agreement));
    if (found.size() == kMostAgreements) break;
  }
  return found;
}

// The longest run of samples without a gap.
Stretch longest_run(const std::vector<PredictedEdge::Sample>& samples) {
  Stretch longest{0, 0};
  size_t first = 0;
  for (size_t i = 1; i <= samples.size(); ++i) {
    if (i < samples.size() && samples[i].along_px - samples[i - 1].along_px < 1.5) continue;
    if (samples[i - 1].along_px - samples[first].along_px > longest.to_px - longest.from_px) {
      longest = {samples[first].along_px, samples[i - 1].along_px};
    }
    first = i;
  }
  return longest;
}

}  // namespace

std::optional<ModelLines> find_model_lines(const ExtractionInput& input, const cv::Rect& window) {
  const std::vector<SearchedEdge> edges = searched_edges(input);
  if (edges.size() < 2) return std::nullopt;
  std::vector<OutlineSample> all;
  for (const SearchedEdge& edge : edges) {
    all.insert(all.end(), edge.samples.begin(), edge.samples.end());
  }
  const GradientWindow gradients = gradients_around(input, all);
  ModelLines found;
  found.polarity = outline_polarity(input, all);
  for (const SearchedEdge& edge : edges) {
    found.of_edge.push_back(find_lines(input, gradients, edge, found.polarity));
  }
  found.agreements = agreements(input, found.of_edge, window);
  return found;
}

std::optional<ImageLine> refitted(const ExtractionInput& input, const FoundLine& found,
                                  const Eigen::Vector2d& vertex, int polarity) {
  constexpr double kOffCornerPx = 4;
  constexpr double kApartPx = 6;
  constexpr double kLeastStretchPx = 5;
  constexpr double kFirstStretchPx = 30;
  const PredictedEdge edge =
      predict_edge(input.view, input.prediction, found.edge,
                   {kOffCornerPx, kFarReachPx, kApartPx, /*is_apart_from_creases=*/true});
  if (edge.is_soft || edge.samples.empty()) return std::nullopt;
  const Stretch run = longest_run(edge.samples);
  std::optional<ImageLine> line = found.line;
  if (!(run.to_px - run.from_px >= kLeastStretchPx)) return std::nullopt;
  // The far end only once the near one has told where it is.
  for (const double to_px : {std::min(run.from_px + kFirstStretchPx, run.to_px), run.to_px}) {
    const double sense = line->direction.dot(edge.direction) >= 0 ? 1 : -1;
    const double vertex_px = line->direction.dot(vertex - line->point);
    const double a = vertex_px + sense * run.from_px;
    const double b = vertex_px + sense * to_px;
    line = fit_blurred_edge(input.image, *line, {std::min(a, b), std::max(a, b)},
                            input.options.search.noise_sd_grey);
    if (!line) return std::nullopt;
  }
  const double floor = floor_px(input, edge, line->contrast_grey, polarity);
  line->covariance(0, 0) += floor * floor;
  return line;
}

}  // namespace sightline
