// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/image_bound.h"

#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <opencv2/core.hpp>

#include "registration/columns_kernel.h"
#include "registration/grey_image.h"
#include "registration/model_view.h"
#include "registration/symmetric.h"
#include "renderer/basis.h"
#include "scenes/mesh/mesh.h"

namespace sightline {
namespace {

constexpr double kWhiteGrey = 255;

// Noise-free light on the focal plane, grey levels, the gain applied.
cv::Mat noise_free(const Scene& scene, Renderer& renderer) {
  return blurred(renderer.render_linear(scene), scene.sensor.psf_sigma_px) *
         (kWhiteGrey * scene.sensor.gain);
}

// The steps of (w, dt) that move the target's rim by `step_px`; a turn about an axis across the
// line of sight moves it less, and by the cosine of nothing at the limb: twice the angle.
Vector6d steps_of(const Scene& scene, double step_px) {
  const double depth_m = scene.cam_from_target.translation.z();
  const double step_m = step_px * depth_m / scene.camera.fx_px;
  const double radius = radius_m(scene.target->mesh);
  Vector6d steps;
  steps << 2 * step_m / radius, 2 * step_m / radius, step_m / radius, step_m, step_m,
      step_m * depth_m / radius;
  return steps;
}

std::vector<cv::Mat> pose_derivatives(const Scene& scene, Renderer& renderer, double step_px) {
  const Vector6d steps = steps_of(scene, step_px);
  std::vector<cv::Mat> derivatives;
  for (int k = 0; k < 6; ++k) {
    std::array<cv::Mat, 2> images;
    for (const int side : {0, 1}) {
      Scene moved = scene;
      moved.cam_from_target =
          retract(scene.cam_from_target, (side == 0 ? 1 : -1) * steps[k] * Vector6d::Unit(k));
      images[static_cast<size_t>(side)] = noise_free(moved, renderer);
    }
    derivatives.push_back((images[0] - images[1]) / (2 * steps[k]));
  }
  return derivatives;
}

// The derivative of the encoded number by linear grey, both of 255.
double encoding_slope(double grey, bool is_srgb) {
  if (!is_srgb) return 1;
  const double x = grey / kWhiteGrey;
  return x <= 0.0031308 ? 12.92 : 1.055 / 2.4 * std::pow(x, 1 / 2.4 - 1);
}

// The variance of each pixel in linear grey levels; zero where the sensor is at its limits.
cv::Mat variance_of(const cv::Mat& grey, const Sensor& sensor) {
  const double step = kWhiteGrey / (std::exp2(sensor.bits) - 1);
  const double read = sensor.gain * sensor.read_noise_grey;
  cv::Mat variance = cv::Mat::zeros(grey.size(), CV_32F);
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      const double level = grey.at<float>(y, x);
      if (level <= 0 || level >= kWhiteGrey) continue;
      const double slope = encoding_slope(level, sensor.is_srgb);
      double sum = read * read + step * step / 12 / (slope * slope);
      if (sensor.full_well_electrons > 0) {
        sum += sensor.gain * kWhiteGrey * level / sensor.full_well_electrons;
      }
      variance.at<float>(y, x) = static_cast<float>(sum);
    }
  }
  return variance;
}

std::optional<Matrix6d> covariance_of(const Eigen::MatrixXd& information) {
  const auto inverse = inverse_of(information);
  if (!inverse) return std::nullopt;
  return Matrix6d(*inverse);
}

// What the images of the target alone are, blurred, in the place where the scene has it.
std::optional<BasisImages> basis_of(const Scene& scene, int samples) {
  BasisDrawer drawer(scene.target->mesh, scene.camera);
  BasisOptions options;
  options.samples_per_pixel = samples;
  options.margin_px = margin_px(scene.sensor.psf_sigma_px);
  options.to_light_in_cam = scene.light.to_light_in_cam;
  return drawer.draw(scene.cam_from_target, options);
}

cv::Mat whole(const cv::Mat& part, const cv::Rect& box, const cv::Size& size) {
  cv::Mat out = cv::Mat::zeros(size, part.type());
  part.copyTo(out(box));
  return out;
}

// The information of the pose from the band alone: in every square the scale of the contrast and a
// level are unknown.
Matrix6d outline_information(std::vector<cv::Mat> pose, const cv::Mat& grey,
                             const cv::Mat& variance, const cv::Mat& band) {
  constexpr double kRidge = 1e-6;  // where a square has but one grey
  pose.push_back(grey);
  pose.push_back(cv::Mat::ones(grey.size(), CV_32F));
  cv::Mat used = variance.clone();
  used.setTo(0, band == 0);
  Matrix6d sum = Matrix6d::Zero();
  for (int y = 0; y < grey.rows; y += kBlockPx) {
    for (int x = 0; x < grey.cols; x += kBlockPx) {
      const cv::Rect square = cv::Rect(x, y, kBlockPx, kBlockPx) & cv::Rect({0, 0}, grey.size());
      if (cv::countNonZero(used(square)) == 0) continue;
      std::vector<cv::Mat> parts;
      for (const cv::Mat& derivative : pose) parts.push_back(derivative(square));
      Eigen::MatrixXd information = image_information(parts, used(square));
      information.diagonal().tail<2>().array() += kRidge;
      sum += marginal_information(information, 6);
    }
  }
  return sum;
}

}  // namespace

Eigen::MatrixXd image_information(std::span<const cv::Mat> derivatives, const cv::Mat& variance) {
  const auto count = static_cast<Eigen::Index>(derivatives.size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd row(count);
  for (int y = 0; y < variance.rows; ++y) {
    for (int x = 0; x < variance.cols; ++x) {
      const float own = variance.at<float>(y, x);
      if (!(own > 0)) continue;
      for (Eigen::Index k = 0; k < count; ++k) {
        row[k] = derivatives[static_cast<size_t>(k)].at<float>(y, x);
      }
      if (row.isZero(0)) continue;
      for (Eigen::Index i = 0; i < count; ++i) {
        for (Eigen::Index k = 0; k <= i; ++k) sum(i, k) += row[i] * row[k] / own;
      }
    }
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index k = 0; k < i; ++k) sum(k, i) = sum(i, k);
  }
  return sum;
}

Eigen::MatrixXd marginal_information(const Eigen::MatrixXd& information, int kept) {
  const Eigen::Index others = information.rows() - kept;
  const Eigen::MatrixXd cross = information.bottomLeftCorner(others, kept);
  Eigen::MatrixXd own = information.bottomRightCorner(others, others);
  // What the image says nothing of costs nothing.
  constexpr double kRidge = 1e-10;
  own.diagonal().array() += kRidge * own.trace() / static_cast<double>(others) + 1e-300;
  Eigen::MatrixXd left = information.topLeftCorner(kept, kept);
  const auto inverse = inverse_of(own);
  if (inverse) left.noalias() -= cross.transpose() * *inverse * cross;
  return left;
}

ImageBounds image_bounds(const Scene& given, Renderer& renderer, const ImageBoundOptions& options) {
  Scene scene = given;
  scene.samples_per_pixel = options.samples_per_pixel;
  const cv::Mat grey = noise_free(scene, renderer);
  const cv::Mat variance = variance_of(grey, scene.sensor);
  std::vector<cv::Mat> derivatives = pose_derivatives(scene, renderer, options.step_px);
  ImageBounds bounds;
  bounds.known_light = covariance_of(image_information(derivatives, variance));
  const auto basis = basis_of(scene, options.samples_per_pixel);
  if (!basis) return bounds;
  const cv::Mat band = whole(outline_band(basis->coverage), basis->box, grey.size());
  const cv::Mat contrast = grey - kWhiteGrey * scene.sensor.gain * scene.background.level;
  bounds.outline = covariance_of(outline_information(derivatives, contrast, variance, band));
  const ModelView view = model_view(*basis, scene.sensor.psf_sigma_px, RegistrationRegion::kImage);
  for (size_t k = 0; k < 4; ++k) {
    derivatives.push_back(whole(view.basis[k], view.box, grey.size()));
  }
  derivatives.push_back(1 - whole(1 - view.basis[4], view.box, grey.size()));
  bounds.unknown_light =
      covariance_of(marginal_information(image_information(derivatives, variance), 6));
  return bounds;
}

}  // namespace sightline
