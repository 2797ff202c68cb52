// SPDX-License-Identifier: MIT
// Refinement of a rigid motion by point-to-plane ICP (Chen, Medioni 1992), coarse to fine, and its
// information matrix. In: a target with its nearest-point index, a source, a start. Out: the motion with
// overlap, residual and information. Thread: back. Allocates nothing.
#pragma once
#include <array>

#include "core/geometry/se3.hpp"
#include "core/proposal/point_grid.hpp"
#include "core/proposal/registration_cloud.hpp"

namespace loopsift {

/// One level of the refinement.
struct IcpStage {
  float max_distance_m = 0;  ///< partners farther apart do not count
  int max_iterations = 0;
  int stride = 1;  ///< every stride-th source point is used
};

/// Two points count as partners when they are near and their normals agree. A partner pair weighs
/// 1 / (σ²(p) + σ²(q)) with σ(p) = floor + slope · d²(p), d the distance from the fragment's origin, its
/// first camera: the range error of structured light grows with the square of range, and its systematic part
/// does not average out in fusion.
struct IcpOptions {
  std::array<IcpStage, 3> stages = {{{0.20F, 8, 4}, {0.10F, 8, 2}, {0.06F, 10, 1}}};
  float min_normal_cosine = 0.7F;
  float sigma_floor_m = 0.005F;
  float sigma_slope_per_m = 0.004F;
  int min_partners = 50;        ///< fewer is a failure
  float converged_m = 2e-4F;    ///< a step below this …
  float converged_rad = 2e-4F;  ///< … and this ends a stage
  float correlated_pairs = 50;  ///< the errors of this many pairs are one error (measured; see refine)
  float max_sigma_m = 0.10F;    ///< a motion that is known worse than this along any axis …
  float max_sigma_rad = 0.10F;  ///< … or about any axis is not determined: a failure
};

/// The target's surface and how to find the nearest point of it.
struct IcpTarget {
  const RegistrationCloud* cloud = nullptr;
  const NearestField* field = nullptr;
};

struct IcpResult {
  bool ok = false;    ///< false: too few partners, or a motion that the partners do not determine
  bool fits = false;  ///< false: too few partners; where they do not determine the motion it is the start's
  Se3 T_target_source;
  int partners = 0;      ///< of all source points, within the last stage's distance
  float residual_m = 0;  ///< RMS of the point-to-plane distances of the partners
  /// Of log(T̂_target_source⁻¹ T_target_source), (t, ω) order.
  Matrix6d information = Matrix6d::Zero();
};

/// The normal equations H ξ = −g of the cost ½ Σ w ρ(r) with r = n_q · (T exp(ξ) p − q), w the pair's weight
/// and ρ(r) = s² r² / (s² + r²) (Geman–McClure) or r², at ξ = 0.
struct PointToPlaneSystem {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double cost = 0;
  double squared_residuals = 0;  ///< Σ r², m²
  int partners = 0;
};

enum class Loss { kSquared, kGemanMcClure };  ///< s is a third of max_distance_m

[[nodiscard]] PointToPlaneSystem point_to_plane_system(const IcpOptions& options, const IcpTarget& target,
                                                       const RegistrationCloud& source, const Se3& T,
                                                       float max_distance_m, int stride, Loss loss);

/// The refined motion. Its information is that of Choi et al. 2015, Σ Gᵀ G over the partners with
/// G = [I | −[p]×], with each error taken along the normal alone (a surface says nothing about sliding along
/// it) and in physical units: Σ w Gᵀ n nᵀ G, divided by the residuals' variance where that exceeds what the
/// weights claim, and by correlated_pairs, since neighbouring pairs share the calibration and the pose errors
/// of the frames they were fused from.
[[nodiscard]] IcpResult refine(const IcpOptions& options, const IcpTarget& target,
                               const RegistrationCloud& source, const Se3& T_start);

}  // namespace loopsift
