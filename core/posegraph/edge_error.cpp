// SPDX-License-Identifier: MIT
#include "core/posegraph/edge_error.hpp"

#include <Eigen/Cholesky>
#include <string>

namespace loopsift {
namespace {

constexpr double kRounding = 1e-9;  // relative to the largest entry

std::string edge_name(const char* kind, std::size_t index, const Edge& edge) {
  return std::string(kind) + " edge " + std::to_string(index) + " (" + std::to_string(edge.a) + " → " +
         std::to_string(edge.b) + ")";
}

Status check_edges(const char* kind, const std::vector<Edge>& edges, int node_count) {
  for (std::size_t k = 0; k < edges.size(); ++k) {
    const Edge& edge = edges[k];
    const bool ends_exist = edge.a >= 0 && edge.b >= 0 && edge.a < node_count && edge.b < node_count;
    if (!ends_exist || edge.a == edge.b)
      return Error{ErrorCode::kUsage, edge_name(kind, k, edge) +
                                          ": its ends must be two different nodes of the " +
                                          std::to_string(node_count) + " in the graph"};
    if (!edge.T_a_b.is_valid())
      return Error{ErrorCode::kNumeric, edge_name(kind, k, edge) + ": its transform is no rigid motion"};
    Matrix6d S;
    if (!square_root_information(edge.information, &S))
      return Error{ErrorCode::kNumeric,
                   edge_name(kind, k, edge) +
                       ": its information is not a finite, symmetric, positive semi-definite matrix"};
  }
  return {};
}

}  // namespace

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

bool square_root_information(const Matrix6d& information, Matrix6d* S) {
  if (!information.allFinite()) return false;
  const double scale = information.cwiseAbs().maxCoeff();
  if ((information - information.transpose()).cwiseAbs().maxCoeff() > 1e-6 * scale) return false;
  const Eigen::LDLT<Matrix6d> ldlt(information);
  const Vector6d d = ldlt.vectorD();
  if (ldlt.info() != Eigen::Success || d.minCoeff() < -kRounding * scale) return false;
  const Matrix6d upper = ldlt.matrixU();
  const Matrix6d permutation = ldlt.transpositionsP() * Matrix6d::Identity();
  *S = d.cwiseMax(0.0).cwiseSqrt().asDiagonal() * upper * permutation;
  return true;
}

Status check_graph(const PoseGraph& graph) {
  const std::size_t n = graph.T_map_node.size();
  if (n == 0 || graph.nodes.size() != n)
    return Error{ErrorCode::kUsage, "the pose graph has " + std::to_string(graph.nodes.size()) +
                                        " nodes and " + std::to_string(n) +
                                        " poses; it needs as many, at least one"};
  for (std::size_t k = 0; k < n; ++k)
    if (!graph.T_map_node[k].is_valid())
      return Error{ErrorCode::kNumeric, "node " + std::to_string(k) + ": its pose is no rigid motion"};
  const Status odometry = check_edges("odometry", graph.odometry, static_cast<int>(n));
  return odometry.ok() ? check_edges("loop", graph.loops, static_cast<int>(n)) : odometry;
}

double edge_chi2(const Edge& edge, const Se3& T_map_a, const Se3& T_map_b) {
  const Vector6d e = edge_error(edge.T_a_b.inverse(), T_map_a, T_map_b);
  return e.dot(edge.information * e);
}

}  // namespace loopsift
