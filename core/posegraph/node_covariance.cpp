// SPDX-License-Identifier: MIT
#include "core/posegraph/node_covariance.hpp"

#include <algorithm>

#include "core/posegraph/edge_error.hpp"
#include "core/posegraph/graph_check.hpp"

namespace loopsift {

NodeCovariance::NodeCovariance(Arena* arena, int max_nodes, int max_blocks)
    : cholesky_(arena, max_nodes, max_blocks),
      part_(arena->carve<int>("posegraph/covariance", static_cast<std::size_t>(max_nodes))),
      column_(arena->carve<Vector6d>("posegraph/covariance", static_cast<std::size_t>(max_nodes))) {}

bool NodeCovariance::compute(const PoseGraph& graph, int node, Matrix6d* covariance) {
  const auto nodes = static_cast<int>(graph.T_map_node.size());
  if (node < 0 || node >= nodes || nodes > static_cast<int>(part_.size())) return false;
  const Span<int> part = part_.first(static_cast<std::size_t>(nodes));
  find_parts(graph, part);
  if (part[static_cast<std::size_t>(node)] != part[0]) return false;
  cholesky_.begin(nodes);
  for (const std::vector<Edge>* list : {&graph.odometry, &graph.loops})
    for (const Edge& edge : *list)
      if (edge.a != 0 && edge.b != 0) cholesky_.connect(edge.a, edge.b);
  if (!cholesky_.analyze()) return false;
  cholesky_.clear();
  // What is fixed, or not joined to what is: any number will do.
  for (int n = 0; n < nodes; ++n)
    if (n == 0 || part[static_cast<std::size_t>(n)] != part[0])
      cholesky_.add_diagonal(n, Matrix6d::Identity());
  for (const std::vector<Edge>* list : {&graph.odometry, &graph.loops})
    for (const Edge& edge : *list) add_edge(graph, edge);
  if (!cholesky_.factorize(0)) return false;
  for (int k = 0; k < 6; ++k) {
    const Span<Vector6d> column = column_.first(static_cast<std::size_t>(nodes));
    std::fill(column.begin(), column.end(), Vector6d(Vector6d::Zero()));
    if (node != 0) column[static_cast<std::size_t>(node)] = Vector6d::Unit(k);
    cholesky_.solve(column);
    covariance->col(k) = column[static_cast<std::size_t>(node)];
  }
  return covariance->allFinite();
}

void NodeCovariance::add_edge(const PoseGraph& graph, const Edge& edge) {
  const Se3& T_map_a = graph.T_map_node[static_cast<std::size_t>(edge.a)];
  const Se3& T_map_b = graph.T_map_node[static_cast<std::size_t>(edge.b)];
  const EdgeLinearization at = linearize_edge(edge.T_a_b.inverse(), T_map_a, T_map_b);
  const Matrix6d J_a = -at.J_b * at.adjoint_ba;
  if (edge.a != 0) cholesky_.add_diagonal(edge.a, J_a.transpose() * edge.information * J_a);
  if (edge.b != 0) cholesky_.add_diagonal(edge.b, at.J_b.transpose() * edge.information * at.J_b);
  if (edge.a != 0 && edge.b != 0)
    cholesky_.add_off_diagonal(edge.a, edge.b, J_a.transpose() * edge.information * at.J_b);
}

}  // namespace loopsift
