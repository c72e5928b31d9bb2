// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/datasets/pictures.h"
#include "eval/metrics/pose_errors.h"
#include "eval/metrics/vsd.h"
#include "eval/score/measures.h"
#include "eval/statistics/bootstrap.h"
#include "eval/statistics/rate_interval.h"
#include "pose/attitude.h"
#include "pose/camera.h"
#include "renderer/truth.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr double kMspdWidth = 640;    // px, the image that MSPD's thresholds are of
constexpr double kAddFraction = 0.1;  // of the diameter
constexpr uint64_t kSeed = 1;         // of the bootstrap

// The estimates of an object in an image that count: as many as instances are asked for, those of
// the best scores, and of those that tie the first. All are indices.
std::vector<size_t> counting_estimates(std::vector<size_t> of_object, size_t count,
                                       std::span<const BopEstimate> estimates) {
  std::stable_sort(of_object.begin(), of_object.end(),
                   [&](size_t a, size_t b) { return estimates[a].score > estimates[b].score; });
  of_object.resize(std::min(count, of_object.size()));
  return of_object;
}

// The depth of an image; none where it is missing, torn, no such picture, or not of the size of the
// image's own.
std::optional<cv::Mat> depth_of(const BopImage& image) {
  if (image.depth_file.empty()) return std::nullopt;
  cv::Mat depth = read_picture(image.depth_file);
  if (depth.channels() != 1 || depth.cols != image.width_px) return std::nullopt;
  if (image.height_px > 0 && depth.rows != image.height_px) return std::nullopt;
  return depth;
}

// Draws what VSD compares.
class Views {
 public:
  Views(const BopImage& image, cv::Mat depth) : k_(image.k) {
    depth.convertTo(depth, CV_64F, image.depth_scale);
    camera_ = {.width_px = depth.cols,
               .height_px = depth.rows,
               .fx_px = k_(0, 0),
               .fy_px = k_(1, 1),
               .cx_px = k_(0, 2),
               .cy_px = k_(1, 2),
               .lens = {}};
    test_mm_ = distances_of_depth(depth, k_);
  }

  const cv::Mat& test_mm() const { return test_mm_; }
  cv::Mat of(const BopModel& model, const Pose& pose) const {
    return distances_of_depth(depth_alone(model.mesh_mm, camera_, pose), k_);
  }

 private:
  Eigen::Matrix3d k_;
  Camera camera_;
  cv::Mat test_mm_;
};

// One object in one image: rows are estimates, best score first, columns the instances asked for.
class Group {
 public:
  Group(const BopImage& image, const BopModel& model, std::span<const BopEstimate> estimates,
        std::vector<size_t> counting, const std::vector<int>& instances)
      : image_(image),
        model_(model),
        estimates_(estimates),
        counting_(std::move(counting)),
        instances_(instances.begin(), instances.end()) {
    for (const size_t e : counting_) {
      for (const size_t g : instances_) pairs_.push_back(pair_of(e, g));
    }
  }

  void add_vsd(const Views& views, double delta_mm) {
    std::vector<double> taus_mm;
    for (int i = 0; i < kBopThresholds; ++i) {
      taus_mm.push_back(bop_fraction(i) * model_.diameter_mm);
    }
    std::vector<cv::Mat> truths;
    for (const size_t g : instances_) {
      truths.push_back(views.of(model_, image_.instances[g].cam_from_model));
    }
    for (size_t row = 0; row < counting_.size(); ++row) {
      const cv::Mat estimated = views.of(model_, estimates_[counting_[row]].cam_from_model);
      for (size_t column = 0; column < instances_.size(); ++column) {
        if (!image_.instances[instances_[column]].has_pose) continue;
        pairs_[row * instances_.size() + column].vsd =
            vsd(views.test_mm(), truths[column], estimated, delta_mm, taus_mm);
      }
    }
  }

  std::vector<BopTarget> targets(size_t image_index, int obj_id) const {
    std::vector<BopTarget> targets(instances_.size());
    for (size_t column = 0; column < instances_.size(); ++column) {
      targets[column].image = image_index;
      targets[column].instance = instances_[column];
      targets[column].obj_id = obj_id;
      targets[column].is_symmetric = model_.symmetries.size() > 1;
      for (size_t row = 0; row < counting_.size(); ++row) {
        targets[column].pairs.push_back(pairs_[row * instances_.size() + column]);
      }
    }
    const double width_scale = kMspdWidth / image_.width_px;
    for (int i = 0; i < kBopThresholds; ++i) {
      const double fraction = bop_fraction(i);
      for_each_match([](const BopPair& p) { return p.mssd_mm; }, fraction * model_.diameter_mm,
                     [&](size_t column, size_t) { targets[column].mssd[i] = true; });
      for_each_match([&](const BopPair& p) { return p.mspd_px * width_scale; }, bop_pixels(i),
                     [&](size_t column, size_t) { targets[column].mspd[i] = true; });
      for (int tau = 0; tau < kBopThresholds; ++tau) {
        for_each_match(
            [&](const BopPair& p) {
              return p.vsd.empty() ? std::numeric_limits<double>::infinity() : p.vsd[tau];
            },
            fraction, [&](size_t column, size_t) { targets[column].vsd[tau][i] = true; });
      }
    }
    const double add_limit_mm = kAddFraction * model_.diameter_mm;
    for_each_match([](const BopPair& p) { return p.add_mm; }, add_limit_mm,
                   [&](size_t column, size_t) { targets[column].is_add_good = true; });
    for_each_match([](const BopPair& p) { return p.adi_mm; }, add_limit_mm,
                   [&](size_t column, size_t) { targets[column].is_adi_good = true; });
    for_each_match([this](const BopPair& p) { return has_model() ? p.mssd_mm : p.t_error_percent; },
                   std::numeric_limits<double>::infinity(),
                   [&](size_t column, size_t row) { targets[column].chosen = row; });
    return targets;
  }

 private:
  bool has_model() const { return model_.points_mm.cols() > 0; }

  BopPair pair_of(size_t e, size_t g) const {
    const Pose& estimated = estimates_[e].cam_from_model;
    const Pose& truth = image_.instances[g].cam_from_model;
    const Pose alike =
        has_model() ? nearest_alike(model_.points_mm, estimated, truth, model_.symmetries) : truth;
    const PairPoses poses{.points_mm = model_.points_mm,
                          .k = image_.k,
                          .symmetries = model_.symmetries,
                          .estimated = estimated,
                          .truth = truth,
                          .alike = alike};
    BopPair pair;
    pair.estimate = e;
    pair.instance = g;
    if (!image_.instances[g].has_pose) return unknown(pair);
    for (const PairMeasure& measure : pair_measures()) {
      const bool is_known = has_model() || !measure.needs_model;
      pair.*measure.number = is_known ? measure.of(poses) : kNoNumber;
    }
    return pair;
  }

  // A pair whose errors nobody knows, which is no match at any threshold.
  static BopPair unknown(BopPair pair) {
    for (const PairMeasure& measure : pair_measures()) pair.*measure.number = kNoNumber;
    return pair;
  }

  // Greedily: the estimates in their order take the free instance of the least error below.
  template <typename Error, typename Match>
  void for_each_match(const Error& error, double threshold, const Match& match) const {
    std::vector<bool> is_taken(instances_.size(), false);
    for (size_t row = 0; row < counting_.size(); ++row) {
      double least = threshold;
      std::optional<size_t> best;
      for (size_t column = 0; column < instances_.size(); ++column) {
        const double value = error(pairs_[row * instances_.size() + column]);
        if (is_taken[column] || !(value < least)) continue;
        least = value;
        best = column;
      }
      if (!best) continue;
      is_taken[*best] = true;
      match(*best, row);
    }
  }

  const BopImage& image_;
  const BopModel& model_;
  std::span<const BopEstimate> estimates_;
  std::vector<size_t> counting_;   // indices of estimates
  std::vector<size_t> instances_;  // indices in the image
  std::vector<BopPair> pairs_;     // row by row
};

double share_of(const BopPasses& passes) {
  return static_cast<double>(std::count(passes.begin(), passes.end(), true)) / kBopThresholds;
}

// The mean of a number over targets; recall and mean recall are such means.
template <typename Number>
BopRate mean_over(std::span<const BopTarget* const> targets, const Number& number,
                  std::string_view name) {
  std::vector<double> values;
  for (const BopTarget* target : targets) values.push_back(number(*target));
  if (values.empty()) return {};
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  return {sum / static_cast<double>(values.size()), bca_mean_interval(values, kSeed, name)};
}

template <typename IsGood>
BopRate rate_over(std::span<const BopTarget* const> targets, const IsGood& is_good) {
  const auto count = std::count_if(targets.begin(), targets.end(),
                                   [&](const BopTarget* t) { return is_good(*t); });
  const auto all = static_cast<int64_t>(targets.size());
  if (all == 0) return {};
  return {static_cast<double>(count) / static_cast<double>(all), rate_interval(count, all)};
}

ErrorSummary summary_of(std::span<const BopTarget* const> targets, double BopPair::*error,
                        double cap, std::string_view name) {
  std::vector<double> errors;
  for (const BopTarget* target : targets) {
    errors.push_back(target->chosen ? target->pairs[*target->chosen].*error
                                    : std::numeric_limits<double>::infinity());
  }
  return summarise(errors, cap, kSeed, name);
}

// Of what needs the models' vertices.
void add_recalls(std::span<const BopTarget* const> targets, bool has_vsd, BopSummary& s) {
  s.ar_mssd = mean_over(
      targets, [](const BopTarget& t) { return recalls_of(t).mssd; }, "ar_mssd");
  s.ar_mspd = mean_over(
      targets, [](const BopTarget& t) { return recalls_of(t).mspd; }, "ar_mspd");
  if (has_vsd) {
    s.ar_vsd = mean_over(
        targets, [](const BopTarget& t) { return recalls_of(t).vsd; }, "ar_vsd");
    s.ar = mean_over(
        targets, [](const BopTarget& t) { return recalls_of(t).mean(); }, "ar");
  }
  s.add_s = rate_over(targets, is_add_s_good);
  for (int i = 0; i < kBopThresholds; ++i) {
    s.mssd_recalls[i] = rate_over(targets, [i](const BopTarget& t) { return t.mssd[i]; }).value;
    s.mspd_recalls[i] = rate_over(targets, [i](const BopTarget& t) { return t.mspd[i]; }).value;
  }
}

BopSummary summary_of(std::span<const BopTarget* const> targets, const BopScores& scores) {
  BopSummary s;
  s.targets = static_cast<int64_t>(targets.size());
  s.estimated = std::count_if(targets.begin(), targets.end(),
                              [](const BopTarget* t) { return t->chosen.has_value(); });
  if (scores.has_models) {
    add_recalls(targets, scores.has_vsd, s);
  } else {
    s.mssd_recalls.fill(kNoNumber);
    s.mspd_recalls.fill(kNoNumber);
  }
  for (const SummaryMeasure& measure : summary_measures()) {
    if (const auto* recall = std::get_if<RecallMeasure>(&measure)) {
      if (scores.has_models || !recall->needs_model) {
        s.*recall->summary = rate_over(targets, recall->is_good);
      }
    } else {
      const auto& error = std::get<ErrorMeasure>(measure);
      s.*error.summary = summary_of(targets, error.error, error.cap, error.stream);
    }
  }
  return s;
}

}  // namespace

TargetRecalls recalls_of(const BopTarget& target) {
  TargetRecalls recalls{share_of(target.mssd), share_of(target.mspd), 0};
  for (const BopPasses& passes : target.vsd) recalls.vsd += share_of(passes);
  recalls.vsd /= kBopThresholds;
  return recalls;
}

bool is_add_s_good(const BopTarget& target) {
  return target.is_symmetric ? target.is_adi_good : target.is_add_good;
}

BopScores score_bop(const BopDataset& dataset, std::span<const BopEstimate> estimates,
                    double vsd_delta_mm, const std::function<void()>& tick) {
  std::map<std::tuple<int, int64_t, int>, std::vector<size_t>> by_object;
  for (size_t i = 0; i < estimates.size(); ++i) {
    const BopEstimate& e = estimates[i];
    by_object[{e.scene_id, e.im_id, e.obj_id}].push_back(i);
  }
  BopScores scores;
  scores.has_faces =
      std::none_of(dataset.models.begin(), dataset.models.end(),
                   [](const auto& entry) { return entry.second.mesh_mm.triangles.empty(); });
  scores.has_vsd = scores.has_faces &&
                   std::any_of(dataset.images.begin(), dataset.images.end(),
                               [](const BopImage& image) { return !image.depth_file.empty(); });
  scores.has_models =
      std::none_of(dataset.models.begin(), dataset.models.end(),
                   [](const auto& entry) { return entry.second.points_mm.cols() == 0; });
  scores.ignored_estimates = estimates.size();
  for (size_t i = 0; i < dataset.images.size(); ++i) {
    const BopImage& image = dataset.images[i];
    std::optional<Views> views;
    const auto depth = scores.has_vsd ? depth_of(image) : std::nullopt;
    if (scores.has_vsd && !depth) ++scores.images_without_depth;
    for (const auto& [obj_id, count] : image.targets) {
      std::vector<size_t> counting =
          counting_estimates(by_object[{image.scene_id, image.im_id, obj_id}], count, estimates);
      scores.ignored_estimates -= counting.size();
      std::erase_if(counting, [&](size_t e) { return !estimates[e].problem.empty(); });
      Group group(image, dataset.models.at(obj_id), estimates, counting,
                  asked_instances(image, obj_id));
      if (depth && !counting.empty()) {
        if (!views) views.emplace(image, *depth);
        group.add_vsd(*views, vsd_delta_mm);
      }
      for (BopTarget& target : group.targets(i, obj_id))
        scores.targets.push_back(std::move(target));
    }
    tick();
  }
  if (scores.images_without_depth == static_cast<int>(dataset.images.size())) {
    scores.has_vsd = false;  // zero would be told of what nobody could measure
  }
  return scores;
}

std::string note_on_vsd(const BopScores& scores) {
  if (!scores.has_faces) {
    return "a model of the data set has points and no faces, so there is no VSD and no AR";
  }
  if (!scores.has_vsd && scores.images_without_depth == 0) {
    return "the data set has images without depth, so there is no VSD and no AR";
  }
  if (!scores.has_vsd) {
    return "the depth of all images is of another size than they or cannot be read, so there is no "
           "VSD and no AR";
  }
  if (scores.images_without_depth == 0) return "";
  return fmt::format(
      "the depth of {} of the images is missing, of another size or cannot be read, and what they "
      "ask for counts as missed by VSD",
      scores.images_without_depth);
}

std::string note_on_units(const BopDataset& dataset, std::span<const BopEstimate> estimates,
                          const BopScores& scores) {
  constexpr double kFar = 100;  // a unit's mistake is a factor of 1000
  bool is_any_chosen = false;
  for (const BopTarget& target : scores.targets) {
    if (!target.chosen) continue;
    is_any_chosen = true;
    const BopPair& pair = target.pairs[*target.chosen];
    const double estimated_mm = estimates[pair.estimate].cam_from_model.translation.norm();
    const double true_mm =
        dataset.images[target.image].instances[pair.instance].cam_from_model.translation.norm();
    if (estimated_mm < kFar * true_mm && true_mm < kFar * estimated_mm) return "";
  }
  if (!is_any_chosen) return "";
  return fmt::format(
      "all estimates are over {:g} times nearer or farther than the truth (t must be "
      "in mm in BOP, in m in SPEED+)",
      kFar);
}

BopSummary summarise(const BopScores& scores) {
  std::vector<const BopTarget*> targets;
  for (const BopTarget& target : scores.targets) targets.push_back(&target);
  return summary_of(targets, scores);
}

std::map<int, BopSummary> summarise_by_object(const BopScores& scores) {
  std::map<int, std::vector<const BopTarget*>> by_object;
  for (const BopTarget& target : scores.targets) by_object[target.obj_id].push_back(&target);
  std::map<int, BopSummary> summaries;
  for (const auto& [obj_id, targets] : by_object) {
    summaries[obj_id] = summary_of(targets, scores);
  }
  return summaries;
}

}  // namespace sightline
