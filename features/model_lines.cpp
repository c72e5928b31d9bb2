// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/model_lines.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "features/blurred_edge.h"
#include "features/edge_run.h"
#include "features/image_line.h"
#include "features/outline_search.h"
#include "features/peak_fit.h"

namespace sightline {
namespace {

constexpr double kGapPx = 2.5;  // kept off an edge's ends, where the next edge bends the gradient
constexpr size_t kFewestSamples = 4;
constexpr size_t kMostEdges = 5;       // of a feature: all combinations of their lines are tried
constexpr int kMostLines = 3;          // that an edge may have
constexpr double kFarReachPx = 80;     // of what is fitted to the grey levels
constexpr size_t kEnoughSamples = 15;  // with fewer, an edge is looked at farther away

// What of the image there is along a predicted edge.
struct EdgeProfile {
  double pivot_px;            // the middle of the samples, along the edge
  std::vector<double> at_px;  // of each sample, along the edge from the pivot
  std::vector<EdgePeaks> peaks;
};

// A line against the predicted edge: at a distance along the edge from the pivot it lies
// offset + slope * distance off it, along the edge's normal.
struct EdgeOffset {
  double offset_px = 0;
  double slope = 0;

  double at(double at_px) const { return offset_px + slope * at_px; }
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
EdgeOffset voted(const EdgeProfile& profile, double half_px, double max_slope) {
  constexpr double kCellPx = 0.5;
  constexpr int kSlopes = 6;  // to either side
  const int half_cells = static_cast<int>(std::ceil(half_px / kCellPx)) + 1;
  const int cells = 2 * half_cells + 1;
  std::vector<float> votes(cells);
  EdgeOffset best;
  float most = 0;
  for (int i = -kSlopes; i <= kSlopes; ++i) {
    const double slope = max_slope * i / kSlopes;
    std::fill(votes.begin(), votes.end(), 0.F);
    for (size_t sample = 0; sample < profile.peaks.size(); ++sample) {
      for (const EdgePeak& peak : profile.peaks[sample]) {
        const double offset_px = peak.offset_px - slope * profile.at_px[sample];
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

// A line along a predicted edge as a model of where the edge's peaks lie. Its slope is known
// beforehand to a standard deviation.
class EdgeLineModel : public PeakModel {
 public:
  EdgeLineModel(const EdgeProfile& profile, const EdgeOffset& start, double slope_sd)
      : at_px_(profile.at_px), known_slope_(known_beforehand(slope_sd)), line_(start) {}

  double expected_px(size_t sample) const override { return line_.at(at_px_[sample]); }

  bool move_to(const std::vector<ChosenPeak>& peaks) override {
    const double n = static_cast<double>(peaks.size());
    double st = 0, stt = 0, so = 0, sto = 0;
    for (const ChosenPeak& chosen : peaks) {
      const double t = at_px_[chosen.sample];
      st += t;
      stt += t * t;
      so += chosen.peak.offset_px;
      sto += t * chosen.peak.offset_px;
    }
    const double determinant = n * (stt + known_slope_) - st * st;
    line_.slope = (n * sto - st * so) / determinant;
    line_.offset_px = (so - line_.slope * st) / n;
    covariance_ << (stt + known_slope_) / determinant, -st / determinant, -st / determinant,
        n / determinant;
    return true;
  }

  const EdgeOffset& line() const { return line_; }

  /// Of offset and slope, for peaks of variance 1.
  const Eigen::Matrix2d& unit_covariance() const { return covariance_; }

 private:
  const std::vector<double>& at_px_;
  double known_slope_;
  EdgeOffset line_;
  Eigen::Matrix2d covariance_ = Eigen::Matrix2d::Zero();
};

struct FittedLine {
  EdgeOffset line;
  double rms_px;
  Eigen::Matrix2d covariance;  // of offset and slope
  std::vector<ChosenPeak> peaks;
};

std::optional<FittedLine> fitted(const EdgeProfile& profile, const EdgeOffset& start,
                                 double max_slope) {
  EdgeLineModel model(profile, start, max_slope / 2);
  auto peaks = fit_to_peaks(profile.peaks, kFewestSamples, model);
  if (!peaks) return std::nullopt;
  const EdgeOffset line = model.line();
  if (std::abs(line.slope) > 1.5 * max_slope) return std::nullopt;
  double squares = 0;
  for (const ChosenPeak& chosen : *peaks) {
    const double residual =
        chosen.peak.offset_px - line.offset_px - line.slope * profile.at_px[chosen.sample];
    squares += residual * residual;
  }
  const double rms_px = std::sqrt(squares / static_cast<double>(peaks->size()));
  const double sd_px = std::max(rms_px, kLeastScatterPx);
  return FittedLine{line, rms_px, model.unit_covariance() * (kSamplesOfOne * sd_px * sd_px),
                    std::move(*peaks)};
}

// The standard deviation, px, of what the fit does not know of; it is added to the fit's own.
// Shading across a rounded edge moves its image: inwards and by more the darker its limb, against a
// darker background; less against a brighter one. Upper estimates, measured on airliners under many
// lights, of the errors that the fit's own sigma leaves unexplained, by the edge's contrast.
double floor_px(bool is_soft, double contrast_grey, int polarity) {
  constexpr double kMostPx = 1.5;
  if (!is_soft) return std::min(kMostPx, std::hypot(0.012, 1.7 / contrast_grey));
  const double against_bright = 2.4 / std::sqrt(contrast_grey);
  const double against_dark = 170 / std::pow(contrast_grey, 1.5);
  if (polarity > 0) return std::min(kMostPx, against_bright);
  return std::min(kMostPx, against_dark);
}

// So much more is the standard deviation of an edge against another part of the target: an upper
// estimate, since the other part's own edges are near and may be taken for it.
constexpr double kOtherPartPx = 0.8;

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

// The line in the image, with the floor of its sigma and the peaks it lies on.
ImageLine image_line(const ExtractionInput& input, const PredictedEdge& edge,
                     const EdgeProfile& profile, const FittedLine& fit, int polarity) {
  ImageLine line;
  line.point = edge.begin + profile.pivot_px * edge.direction + fit.line.offset_px * edge.normal;
  line.direction = (edge.direction + fit.line.slope * edge.normal).normalized();
  line.rms_px = fit.rms_px;
  line.contrast_grey = mean_contrast_grey(fit.peaks);
  line.covariance = fit.covariance;
  const double floor = floor_px(input, edge, line.contrast_grey, polarity);
  line.covariance(0, 0) += floor * floor;
  // Where the edge's normal is the direction turned the other way round, offset and slope both
  // change their sign, and their covariance does not.
  for (const ChosenPeak& chosen : fit.peaks) {
    const double along_px = profile.pivot_px + profile.at_px[chosen.sample];
    line.edge_pixels.push_back(edge.begin + along_px * edge.direction +
                               chosen.peak.offset_px * edge.normal);
  }
  return line;
}

// The profile without the peaks that are on a line.
EdgeProfile without(const EdgeOffset& line, EdgeProfile profile) {
  constexpr double kOnLinePx = 1.5;
  for (size_t i = 0; i < profile.peaks.size(); ++i) {
    EdgePeaks left;
    for (const EdgePeak& peak : profile.peaks[i]) {
      if (std::abs(peak.offset_px - line.at(profile.at_px[i])) > kOnLinePx) left.add(peak);
    }
    profile.peaks[i] = left;
  }
  return profile;
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

EdgeProfile profile_of(const ExtractionInput& input, const GradientWindow& gradients,
                       const SearchedEdge& searched, int polarity) {
  const PredictedEdge& edge = searched.edge;
  const double half_px = search_half_px(input, edge.normal);
  const double threshold = gradient_threshold(input.options.search);
  EdgeProfile profile;
  profile.pivot_px = (edge.samples.front().along_px + edge.samples.back().along_px) / 2;
  profile.at_px.reserve(searched.samples.size());
  profile.peaks.reserve(searched.samples.size());
  for (size_t i = 0; i < searched.samples.size(); ++i) {
    const OutlineSample& sample = searched.samples[i];
    profile.at_px.push_back(edge.samples[i].along_px - profile.pivot_px);
    profile.peaks.push_back(find_peaks(gradients, sample.pixel, edge.normal, half_px,
                                       sample.borders_target ? 0 : polarity, threshold));
  }
  return profile;
}

// The lines along a predicted edge, best first: each is fitted to what the ones before it leave.
std::vector<FoundLine> find_lines(const ExtractionInput& input, const GradientWindow& gradients,
                                  const SearchedEdge& searched, int polarity) {
  const SearchOptions& options = input.options.search;
  const double half_px = search_half_px(input, searched.edge.normal);
  const double max_slope = is_prior_good(input) ? options.good_max_slope : options.max_slope;
  EdgeProfile profile = profile_of(input, gradients, searched, polarity);
  std::optional<Eigen::Vector2d> outward;
  if (!searched.edge.is_crease && !borders_other_part(searched.edge)) {
    outward = searched.edge.normal;
  }
  std::vector<FoundLine> lines;
  for (int i = 0; i < kMostLines; ++i) {
    const auto fit = fitted(profile, voted(profile, half_px, max_slope), max_slope);
    if (!fit) break;
    const double support =
        static_cast<double>(fit->peaks.size()) / static_cast<double>(profile.peaks.size());
    lines.push_back({searched.index, support, searched.edge.is_soft, outward,
                     image_line(input, searched.edge, profile, *fit, polarity)});
    profile = without(fit->line, std::move(profile));
  }
  return lines;
}

// The lines without their evidence, and with a slack added to the variance of their offsets.
std::vector<std::vector<ImageLine>> with_slack(const std::vector<std::vector<FoundLine>>& lines_of,
                                               double slack_px2) {
  std::vector<std::vector<ImageLine>> slack_lines;
  for (const auto& candidates : lines_of) {
    slack_lines.emplace_back();
    for (const FoundLine& found : candidates) {
      ImageLine line;
      line.point = found.line.point;
      line.direction = found.line.direction;
      line.covariance = found.line.covariance;
      line.covariance(0, 0) += slack_px2;
      slack_lines.back().push_back(std::move(line));
    }
  }
  return slack_lines;
}

// All ways in which two or more lines agree on a point in the window, best first, of those on
// nearly the same point only the best.
std::vector<Agreement> agreements_of(const ExtractionInput& input,
                                     const std::vector<std::vector<FoundLine>>& lines_of,
                                     const cv::Rect& window) {
  // What a line may err, and the prediction, near a corner that is not yet known.
  constexpr double kSlackPx2 = 0.25;
  const std::vector<std::vector<ImageLine>> slack_lines = with_slack(lines_of, kSlackPx2);
  std::vector<size_t> lines_of_edge;
  for (const std::vector<FoundLine>& lines : lines_of) lines_of_edge.push_back(lines.size());
  AgreementRules rules;
  rules.prior_information = prior_information(input.prediction, kSlackPx2);
  rules.same_px = 1;
  rules.meeting = [&](std::span<const LinePick> picks) {
    std::vector<ImageLine> lines;
    for (const LinePick& pick : picks) lines.push_back(slack_lines[pick.edge][pick.line]);
    return meeting_of(lines, kLeastMeetingDeg);
  };
  rules.support = [&](const LinePick& pick, const Eigen::Vector2d&) {
    return lines_of[pick.edge][pick.line].support;
  };
  return find_agreements(lines_of_edge, input.prediction, window, rules);
}

}  // namespace

std::optional<ModelLines> find_model_lines(const ExtractionInput& input, const cv::Rect& window) {
  const std::vector<SearchedEdge> edges = searched_edges(input);
  if (edges.empty()) return std::nullopt;
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
  found.agreements = agreements_of(input, found.of_edge, window);
  return found;
}

std::optional<ImageLine> refitted(const ExtractionInput& input, const FoundLine& found,
                                  const Eigen::Vector2d& vertex, int polarity) {
  constexpr double kLeastStretchPx = 5;
  constexpr double kFirstStretchPx = 30;
  const PredictedEdge edge =
      predict_edge(input.view, input.prediction, found.edge,
                   {kOffCornerPx, kFarReachPx, kApartPx, /*is_apart_from_creases=*/true});
  if (edge.is_soft || edge.samples.empty()) return std::nullopt;
  const EdgeRun run = longest_unbroken_run(edge);
  if (!(run.length_px() >= kLeastStretchPx)) return std::nullopt;
  std::optional<ImageLine> line = found.line;
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
