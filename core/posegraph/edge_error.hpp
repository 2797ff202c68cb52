// SPDX-License-Identifier: MIT
// The error of one edge and its derivatives, shared by the solvers. Fixed size, never allocates.
//
// e = log(T̂_a_b⁻¹ T_map_a⁻¹ T_map_b), poses perturbed on the right, T ← T exp(δ). With E = exp(e) and
// Ad = Ad(T_map_b⁻¹ T_map_a):  E exp(δ_b) gives ∂e/∂δ_b = J_r⁻¹(e);  exp(−δ_a) moved through the product
// gives ∂e/∂δ_a = −J_r⁻¹(e) Ad  (Barfoot, State Estimation for Robotics, 2017, 9.2; J_r(e) = J_l(−e)).
#pragma once
#include "core/geometry/se3.hpp"
#include "core/posegraph/pose_graph.hpp"

namespace loopsift {

/// Error and Jacobians of one edge at the poses of its ends, not weighted.
struct EdgeLinearization {
  Vector6d error;       ///< e, (t, ω) order, in the frame of b
  Matrix6d J_b;         ///< ∂e/∂δ_b
  Matrix6d adjoint_ba;  ///< Ad(T_map_b⁻¹ T_map_a);  ∂e/∂δ_a = −J_b · adjoint_ba
};

/// e for the measurement's inverse T_b_a = T̂_a_b⁻¹.
[[nodiscard]] Vector6d edge_error(const Se3& T_b_a, const Se3& T_map_a, const Se3& T_map_b);
[[nodiscard]] EdgeLinearization linearize_edge(const Se3& T_b_a, const Se3& T_map_a, const Se3& T_map_b);

}  // namespace loopsift
