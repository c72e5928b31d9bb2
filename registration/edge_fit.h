// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "features/prediction.h"
#include "pose/pose.h"
#include "registration/grey_image.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// How far an outline must stand out at a pose to be believed there: at the right poses of four
/// photographs of two printed cubes it does 3.7 to 6.3 times, of a finely printed brick that is
/// rendered 2.8 times, at poses that are wrong along most of the outline 0.8 to 2.2 times. One that
/// is wrong along a part of it (2.2 to 3.4) is for the support to tell.
inline constexpr double kLeastOutlineContrast = 2.5;

/// A pose at which an image shows a mesh's edges.
struct EdgeFit {
  Pose cam_from_target;
  Matrix6d covariance = Matrix6d::Zero();  ///< of (w, dt), prior included; radians and metres
  double support = 0;                      ///< edge_support there
  double contrast = 0;                     ///< outline_contrast there
  int drawings = 0;                        ///< of the mesh, by all fits

  bool is_believable() const { return contrast >= kLeastOutlineContrast; }
};

/// The best of a few fits of a mesh's edges to those of an image: draws from the prior are judged
/// by their edge_support, the best are drawn about anew, closer and on a sharper image, and from
/// the best five the nearest edges along the normals are followed (as Drummond and Cipolla, PAMI
/// 24(7), 2002) by least squares with Tukey's weights. For targets whose faces are printed: grey
/// levels then say nothing, while outline and creases stay where they are. The same for the same
/// image and prior. None where the mesh shows less than 30 px of edges. Neighbouring points of an
/// edge err together; the covariance counts 30 of them as one.
std::optional<EdgeFit> fit_edges(const GreyImage& image, const Mesh& mesh, const PosePrior& prior);

/// The edge_support of another pose, to compare with that of such a fit.
double edge_support_at(const GreyImage& image, const Mesh& mesh, const Pose& cam_from_target);

}  // namespace sightline
