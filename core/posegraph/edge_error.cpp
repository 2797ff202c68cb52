// SPDX-License-Identifier: MIT
#include "core/posegraph/edge_error.hpp"

namespace loopsift {

Vector6d edge_error(const Se3& T_b_a, const Se3& T_map_a, const Se3& T_map_b) {
  return (T_b_a * (T_map_a.inverse() * T_map_b)).log();
}

EdgeLinearization linearize_edge(const Se3& T_b_a, const Se3& T_map_a, const Se3& T_map_b) {
  EdgeLinearization edge;
  const Se3 T_a_b = T_map_a.inverse() * T_map_b;
  edge.error = (T_b_a * T_a_b).log();
  edge.J_b = se3_left_jacobian_inverse(-edge.error);
  edge.adjoint_ba = T_a_b.inverse().adjoint();
  return edge;
}

double edge_chi2(const Edge& edge, const Se3& T_map_a, const Se3& T_map_b) {
  const Vector6d e = edge_error(edge.T_a_b.inverse(), T_map_a, T_map_b);
  return e.dot(edge.information * e);
}

}  // namespace loopsift
