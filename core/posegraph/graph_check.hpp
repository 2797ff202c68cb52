// SPDX-License-Identifier: MIT
// What a graph must be before a solver may take it, shared by the solvers.
#pragma once
#include "core/base/result.hpp"
#include "core/base/span.hpp"
#include "core/posegraph/pose_graph.hpp"

namespace loopsift {

/// S with SᵀS = information, so that ‖S e‖² = eᵀ Λ e: D^½ Lᵀ P of the pivoted Cholesky factor, which takes
/// semi-definite matrices too. False when the matrix is not finite, not symmetric or has a negative
/// eigenvalue (beyond rounding). Never allocates.
[[nodiscard]] bool square_root_information(const Matrix6d& information, Matrix6d* S);

/// Whether sizes agree and every edge joins two different nodes; the error names the edge. Allocates only for
/// an error.
[[nodiscard]] Status check_structure(const PoseGraph& graph);

/// check_structure, and every pose a rigid motion and every information matrix one.
[[nodiscard]] Status check_graph(const PoseGraph& graph);

/// first_of_part[n] = the lowest node that edges join to node n (n itself when it is that node). The span has
/// one place per node; the graph has passed check_structure. Never allocates.
void find_parts(const PoseGraph& graph, Span<int> first_of_part);

}  // namespace loopsift
