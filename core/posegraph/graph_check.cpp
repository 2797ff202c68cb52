// SPDX-License-Identifier: MIT
#include "core/posegraph/graph_check.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <string>

namespace loopsift {
namespace {

constexpr double kRounding = 1e-9;  // relative to the largest entry

std::string edge_name(const char* kind, std::size_t index, const Edge& edge) {
  return std::string(kind) + " edge " + std::to_string(index) + " (" + std::to_string(edge.a) + " → " +
         std::to_string(edge.b) + ")";
}

Status check_ends(const char* kind, const std::vector<Edge>& edges, int node_count) {
  for (std::size_t k = 0; k < edges.size(); ++k) {
    const Edge& edge = edges[k];
    const bool exist = edge.a >= 0 && edge.b >= 0 && edge.a < node_count && edge.b < node_count;
    if (!exist || edge.a == edge.b)
      return Error{ErrorCode::kUsage, edge_name(kind, k, edge) +
                                          ": its ends must be two different nodes of the " +
                                          std::to_string(node_count) + " in the graph"};
  }
  return {};
}

Status check_numbers(const char* kind, const std::vector<Edge>& edges) {
  for (std::size_t k = 0; k < edges.size(); ++k) {
    if (!edges[k].T_a_b.is_valid())
      return Error{ErrorCode::kNumeric, edge_name(kind, k, edges[k]) + ": its transform is no rigid motion"};
    Matrix6d S;
    if (!square_root_information(edges[k].information, &S))
      return Error{ErrorCode::kNumeric,
                   edge_name(kind, k, edges[k]) +
                       ": its information is not a finite, symmetric, positive semi-definite matrix"};
  }
  return {};
}

int root(Span<int> parent, int node) {
  while (parent[static_cast<std::size_t>(node)] != node) {
    int& up = parent[static_cast<std::size_t>(node)];
    up = parent[static_cast<std::size_t>(up)];
    node = up;
  }
  return node;
}

}  // namespace

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

Status check_structure(const PoseGraph& graph) {
  const std::size_t n = graph.T_map_node.size();
  if (n == 0 || graph.nodes.size() != n)
    return Error{ErrorCode::kUsage, "the pose graph has " + std::to_string(graph.nodes.size()) +
                                        " nodes and " + std::to_string(n) +
                                        " poses; it needs as many, at least one"};
  Status odometry = check_ends("odometry", graph.odometry, static_cast<int>(n));
  return odometry.ok() ? check_ends("loop", graph.loops, static_cast<int>(n)) : odometry;
}

Status check_graph(const PoseGraph& graph) {
  if (Status status = check_structure(graph); !status.ok()) return status;
  for (std::size_t k = 0; k < graph.T_map_node.size(); ++k)
    if (!graph.T_map_node[k].is_valid())
      return Error{ErrorCode::kNumeric, "node " + std::to_string(k) + ": its pose is no rigid motion"};
  Status odometry = check_numbers("odometry", graph.odometry);
  return odometry.ok() ? check_numbers("loop", graph.loops) : odometry;
}

void find_parts(const PoseGraph& graph, Span<int> first_of_part) {
  const int n = static_cast<int>(graph.T_map_node.size());
  for (int node = 0; node < n; ++node) first_of_part[static_cast<std::size_t>(node)] = node;
  for (const std::vector<Edge>* edges : {&graph.odometry, &graph.loops})
    for (const Edge& edge : *edges) {
      const int a = root(first_of_part, edge.a), b = root(first_of_part, edge.b);
      first_of_part[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  for (int node = 0; node < n; ++node)
    first_of_part[static_cast<std::size_t>(node)] = root(first_of_part, node);
}

}  // namespace loopsift
