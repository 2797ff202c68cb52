// SPDX-License-Identifier: MIT
// Pairwise consistency maximisation: two loops z₁ (from i to j) and z₂ (from k to l) are consistent when the
// cycle through both and the odometry between their ends closes (eq. 5, there for loops between two robots):
//
//     ‖ log( z₁ · x_jl · z₂⁻¹ · x_ki ) ‖²_Σ ≤ γ
//
// The largest set of loops that are consistent in pairs, a maximum clique, is kept. Σ is the covariance of
// the cycle, to first order: each measurement's, carried to the cycle's end by the adjoint. Odometry that
// both its parts pass through enters once, with both its effects.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "tools/loopsift_tool/filters/max_clique.hpp"
#include "tools/loopsift_tool/filters/weighted_graph.hpp"

namespace loopsift::tool {
namespace {

class Cycles {
 public:
  explicit Cycles(const PoseGraph& graph) : graph_(graph), edge_to_(graph.nodes.size(), nullptr) {
    for (const Edge& edge : graph.odometry)
      if (edge.b == edge.a + 1) edge_to_[static_cast<std::size_t>(edge.b)] = &edge;
    covariance_to_.resize(edge_to_.size());
    for (std::size_t n = 0; n < edge_to_.size(); ++n)
      if (edge_to_[n] != nullptr) covariance_to_[n] = edge_to_[n]->information.inverse();
  }

  /// Squared Mahalanobis distance of the cycle through both loops from the identity. Where the odometry does
  /// not connect their ends, nothing speaks against them: 0.
  [[nodiscard]] double chi2(const Loop& one, const Loop& other) const {
    const int i = node(one.i), j = node(one.j), k = node(other.i), l = node(other.j);
    if (!connected(j, l) || !connected(k, i)) return 0.0;
    const Se3 back = other.T_i_j.inverse() * pose(k).inverse() * pose(i);  // z₂⁻¹ x_ki
    const Se3 after_one = pose(j).inverse() * pose(l) * back;
    const Matrix6d J_one = after_one.inverse().adjoint(), J_other = back.inverse().adjoint();
    Matrix6d covariance = J_one * one.information.inverse() * J_one.transpose() +
                          J_other * other.information.inverse() * J_other.transpose();
    const int begin = std::min({j, l, k, i}), end = std::max({j, l, k, i});
    for (int n = begin + 1; n <= end; ++n) {
      const Matrix6d J = passes(n, j, l) * (pose(n).inverse() * pose(l) * back).inverse().adjoint() +
                         passes(n, k, i) * (pose(n).inverse() * pose(i)).inverse().adjoint();
      if (!J.isZero(0.0)) covariance += J * covariance_to_[static_cast<std::size_t>(n)] * J.transpose();
    }
    const Vector6d error = (one.T_i_j * after_one).log();
    return error.dot(covariance.ldlt().solve(error));
  }

 private:
  [[nodiscard]] int node(FragmentId fragment) const { return graph_.first_node[fragment.index()]; }
  [[nodiscard]] const Se3& pose(int n) const { return graph_.T_map_node[static_cast<std::size_t>(n)]; }
  // How the way from `from` to `to` passes the edge that ends at node n: 1 forwards, −1 backwards, 0 not.
  [[nodiscard]] static double passes(int n, int from, int to) {
    if (from < n && n <= to) return 1.0;
    return to < n && n <= from ? -1.0 : 0.0;
  }
  [[nodiscard]] bool connected(int from, int to) const {
    for (int n = std::min(from, to) + 1; n <= std::max(from, to); ++n)
      if (edge_to_[static_cast<std::size_t>(n)] == nullptr) return false;
    return true;
  }

  const PoseGraph& graph_;
  std::vector<const Edge*> edge_to_;  // by the node at its end
  std::vector<Matrix6d> covariance_to_;
};

std::vector<std::vector<bool>> consistency(const PoseGraph& graph, Span<const Loop> loops, double bound) {
  const Cycles cycles(graph);
  std::vector<std::vector<bool>> consistent(loops.size(), std::vector<bool>(loops.size(), false));
  for (std::size_t a = 0; a < loops.size(); ++a)
    for (std::size_t b = a + 1; b < loops.size(); ++b)
      consistent[a][b] = consistent[b][a] = cycles.chi2(loops[a], loops[b]) <= bound;
  return consistent;
}

}  // namespace

Expected<FilterResult> run_pairwise_consistency(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                const PairwiseConsistencyOptions& options) {
  Expected<WeightedGraph> graph = WeightedGraph::make(odometry_graph, loops, WeightPer::kLoop);
  if (!graph.ok()) return graph.error();
  const MaxClique clique =
      max_clique(consistency(odometry_graph, loops, options.max_chi2), options.clique_budget);
  std::vector<bool> chosen(loops.size(), false);
  for (const int loop : clique.members) chosen[static_cast<std::size_t>(loop)] = true;
  return finish_with(chosen, &*graph);
}

}  // namespace loopsift::tool
