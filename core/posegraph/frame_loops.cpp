// SPDX-License-Identifier: MIT
#include "core/posegraph/pose_graph.hpp"

namespace loopsift {
namespace {

// An error e of the loop, T_i_j = T̂_i_j exp(e), shows on an edge that ends T_from further on as Ad(T_from⁻¹)
// e, for T exp(e) T_from = T T_from exp(Ad(T_from⁻¹) e). So the same χ² needs Ad(T_from)ᵀ Λ Ad(T_from).
Matrix6d carried_information(const Matrix6d& information, const Se3& T_from) {
  const Matrix6d A = T_from.adjoint();
  return A.transpose() * information * A;
}

}  // namespace

void append_frame_loops(const PoseGraph& graph, const Loop& loop, std::vector<Edge>* edges) {
  const int i_begin = graph.first_node[loop.i.index()], i_end = graph.first_node[loop.i.index() + 1];
  const int j_begin = graph.first_node[loop.j.index()], j_end = graph.first_node[loop.j.index() + 1];
  const int count = (j_end - j_begin) + (i_end - i_begin) - 1;  // reference to reference appears once
  const Matrix6d share = loop.information / count;
  const Se3 T_j_i = loop.T_i_j.inverse();
  for (int node = j_begin; node < j_end; ++node) {
    const Se3& T_j_node = graph.nodes[static_cast<std::size_t>(node)].T_fragment_node;
    edges->push_back({i_begin, node, loop.T_i_j * T_j_node, carried_information(share, T_j_node), loop.id});
  }
  for (int node = i_begin + 1; node < i_end; ++node) {
    // Measured the other way round: T_j_i exp(…) = exp(−e) T̂_j_i, so T_from is T̂_j_node as a whole.
    const Se3 T_j_node = T_j_i * graph.nodes[static_cast<std::size_t>(node)].T_fragment_node;
    edges->push_back({j_begin, node, T_j_node, carried_information(share, T_j_node), loop.id});
  }
}

}  // namespace loopsift
