// SPDX-License-Identifier: MIT
// How well the graph knows one pose, given that its first node is where it is: the node's block of H⁻¹, H the
// Gauss–Newton approximation Σ Jᵀ Λ J of the cost at the graph's poses (Barfoot, State Estimation for
// Robotics, 2017, 9.2). In: a graph at its minimum. Out: a covariance. Capacity: fixed. Thread: back. Never
// allocates after construction.
#pragma once
#include "core/base/arena.hpp"
#include "core/posegraph/block_cholesky.hpp"
#include "core/posegraph/pose_graph.hpp"

namespace loopsift {

class NodeCovariance {
 public:
  /// Room for max_nodes nodes and max_blocks blocks of the factor under its diagonal.
  NodeCovariance(Arena* arena, int max_nodes, int max_blocks);

  /// Of T_map_node, (t, ω) order, perturbed on the right: m², m·rad, rad². Zero for the first node. False
  /// when it is not known (no edges join the node to the first one, or the matrix is singular) or the graph
  /// is larger than the room for it.
  [[nodiscard]] bool compute(const PoseGraph& graph, int node, Matrix6d* covariance);

 private:
  void add_edge(const PoseGraph& graph, const Edge& edge);

  BlockCholesky cholesky_;
  Span<int> part_;  // see find_parts()
  Span<Vector6d> column_;
};

}  // namespace loopsift
